#!/usr/bin/env python3
"""Draws docs/images/error-falls.svg from the JSON of `trueweld improve`, and the arm that it is of.

    trueweld improve fixtures/campaigns/backlash --json out/improve.json
    python3 docs/error-falls.py out/improve.json fixtures/campaigns/backlash > docs/images/error-falls.svg

Each step is a bar: its score where nothing was fitted. The arm stands as in
the first row of the campaign's log `weld-1`, seen from the side; the joints of effects are marked.
"""

import csv
import json
import math
import sys
import tomllib

BLUE, ORANGE, GREY, INK = "#2a6fb0", "#d9701f", "#9aa3ab", "#24292f"


def rotated(axis, angle, v):
    """v turned about the unit vector axis (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    dot = sum(a * b for a, b in zip(axis, v))
    cross = [axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]]
    return [c * v[i] + s * cross[i] + (1 - c) * dot * axis[i] for i in range(3)]


def arm(robot, angles):
    """Places of the joints and of the tool centre point in B, m."""
    turns, at, places = [], [0.0, 0.0, 0.0], []

    def in_base(v):
        for axis, angle in reversed(turns):
            v = rotated(axis, angle, v)
        return v

    for joint, angle in zip(robot["joint"], angles):
        at = [a + b for a, b in zip(at, in_base(joint["origin_m"]))]
        places.append(at)
        turns.append((joint["axis"], angle))
    tool = robot["tool"]
    tip = [a + b for a, b in zip(tool["flange_offset_m"], tool["tcp_from_flange_m"])]
    return places, [a + b for a, b in zip(at, in_base(tip))]


def label(step):
    added = [f"{e['effect']} at {e['at']}".removesuffix(" at ") for e in step["added"]]
    return "+ " + ", ".join(added) if added else "recalibrated"


def main():
    result, campaign = json.load(open(sys.argv[1])), sys.argv[2]
    robot = tomllib.load(open(f"{campaign}/robot.toml", "rb"))
    row = next(csv.DictReader(open(f"{campaign}/weld-1/samples.csv")))
    joints, tip = arm(robot, [float(row[f"qe{i}_rad"]) for i in range(1, 7)])
    steps = result["steps"]
    found = {e["at"] for s in steps for e in s["added"]}

    out = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 340" font-family="sans-serif" font-size="15">',
        '<rect width="900" height="340" fill="white"/>',
    ]

    def draw(text):
        out.append(text)

    def place(p):
        return 40 + 125 * p[0], 300 - 125 * p[2]

    # The arm: base, links, tool, plate.
    plate = place([tip[0], 0, tip[2]])
    draw(f'<rect x="{plate[0] - 70:.0f}" y="{plate[1]:.0f}" width="140" height="10" fill="{GREY}"/>')
    foot = place([0, 0, 0])
    draw(f'<rect x="{foot[0] - 30:.0f}" y="{foot[1] - 8:.0f}" width="60" height="16" fill="{INK}"/>')
    points = [place(p) for p in [[0, 0, 0], [0, 0, joints[1][2]], *joints[1:], tip]]
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    draw(f'<polyline points="{line}" fill="none" stroke="{GREY}" stroke-width="14" stroke-linejoin="round"/>')
    for joint, p in sorted(zip(robot["joint"], joints), key=lambda jp: jp[0]["name"] in found):
        x, y = place(p)
        if joint["name"] in found:
            draw(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="12" fill="{ORANGE}"/>')
            draw(f'<text x="{x + 20:.1f}" y="{y + 5:.1f}" fill="{ORANGE}" font-weight="bold">{joint["name"]}</text>')
        else:
            draw(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="{INK}"/>')
    draw(f'<text x="40" y="328" fill="{INK}">{robot["name"].split(" + ")[0]}</text>')

    # The scores, from 0.
    left, right, high = 580, 860, max(s["holdout_score"] for s in steps) * 1.3

    def across(score):
        return left + (right - left) * score / high

    draw(f'<text x="400" y="36" fill="{INK}" font-weight="bold">Error over noise, on data that were not fitted</text>')
    for i, step in enumerate(steps):
        y, score = 66 + 62 * i, step["holdout_score"]
        name = "model as given" if i == 0 else label(step)
        colour = BLUE if i == len(steps) - 1 else GREY
        draw(f'<text x="{left - 12}" y="{y + 23}" fill="{INK}" text-anchor="end">{name}</text>')
        draw(f'<rect x="{left}" y="{y}" width="{across(score) - left:.1f}" height="36" fill="{colour}"/>')
        draw(f'<text x="{across(score) + 8:.1f}" y="{y + 23}" fill="{INK}">{score:.3g}</text>')
    floor, foot = across(1), 66 + 62 * len(steps)
    draw(f'<line x1="{floor:.1f}" y1="52" x2="{floor:.1f}" y2="{foot}" stroke="{ORANGE}" stroke-dasharray="5 4" stroke-width="2"/>')
    draw(f'<text x="{floor:.1f}" y="{foot + 20}" fill="{ORANGE}" text-anchor="middle">noise floor</text>')
    draw("</svg>")
    print("\n".join(out))


main()
