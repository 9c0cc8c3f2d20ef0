//! The layouts that the viewer opens with: of welds, the cell on the left, time series on the
//! right, events below; of responses to a step, time series side by side.
//!
//! Views are logged by their archetypes, since the typed layout of the Rust library has no camera,
//! grid or axis range.

use super::shown::{DrawnRun, ORIGIN, SINCE_STEP};
use super::signals::{DESIRED, GROUPS, Of, idle};
use super::step::{self, SetPointStep};
use super::writer::{RecordError, Store, Writer};
use crate::MILLI;
use nalgebra::{Rotation3, Vector3};
use re_log_types::{TimePoint, Timeline};
use re_sdk_types::AsComponents;
use re_sdk_types::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use re_sdk_types::blueprint::{archetypes as view, components as part};
use re_sdk_types::components::Color;
use re_sdk_types::datatypes::{
    AbsoluteTimeRange, Range1D, TimeInt, TimeRange, TimeRangeBoundary, Uuid,
};
use std::io::Write;
use trueweld_core::JOINTS;
use trueweld_estimate::residuals::compare::LogComparison;
use trueweld_plant::simulate::{Phase, RecordRow};

/// Time shown before a step, s.
const BEFORE_STEP: f64 = 0.2;

/// Room for the legends at the right of the responses to a step, over the time recorded after it.
const LEGEND_SHARE: f64 = 0.25;

/// A container or view of the layout.
struct Node {
    entity: String,
    id: [u8; 16],
}

struct Layout<'a, W: Write> {
    writer: &'a mut Writer<W>,
    count: u32,
}

impl<W: Write> Layout<'_, W> {
    fn log(&mut self, entity: &str, what: &dyn AsComponents) -> Result<(), RecordError> {
        let when = TimePoint::default().with(Timeline::new_sequence("blueprint"), 0);
        self.writer.one(Store::Layout, entity, when, what)
    }

    fn node(&mut self, kind: &str) -> Node {
        self.count += 1;
        let mut id = [0; 16];
        id[6] = 0x40;
        id[8] = 0x80;
        id[12..].copy_from_slice(&self.count.to_be_bytes());
        Node { entity: format!("{kind}/00000000-0000-4000-8000-{:012x}", self.count), id }
    }

    fn view(
        &mut self,
        class: &str,
        name: &str,
        contents: &[String],
        properties: &[(&str, &dyn AsComponents)],
    ) -> Result<Node, RecordError> {
        let node = self.node("view");
        let query = contents.iter().map(|c| part::QueryExpression(c.as_str().into()));
        self.log(&format!("{}/ViewContents", node.entity), &view::ViewContents::new(query))?;
        let class = part::ViewClass(class.into());
        self.log(
            &node.entity,
            &view::ViewBlueprint::new(class).with_display_name(name).with_space_origin("/"),
        )?;
        for (property, value) in properties {
            self.log(&format!("{}/{property}", node.entity), *value)?;
        }
        Ok(node)
    }

    fn container(
        &mut self,
        kind: part::ContainerKind,
        children: &[Node],
        shares: &[f32],
    ) -> Result<Node, RecordError> {
        let node = self.node("container");
        let contents = children.iter().map(|c| part::IncludedContent(c.entity.as_str().into()));
        let mut container = view::ContainerBlueprint::new(kind).with_contents(contents);
        container = match kind {
            part::ContainerKind::Vertical => {
                container.with_row_shares(shares.iter().map(|s| part::RowShare((*s).into())))
            }
            part::ContainerKind::Horizontal => {
                container.with_col_shares(shares.iter().map(|s| part::ColumnShare((*s).into())))
            }
            _ => container,
        };
        self.log(&node.entity, &container)?;
        Ok(node)
    }

    /// The words beside the pictures, as tabs: what is shown, what it is of, and `last`.
    fn words(&mut self, last: Option<Node>) -> Result<Node, RecordError> {
        let mut tabs = Vec::new();
        for (name, entity) in [("what is shown", "/about"), ("what it is of", ORIGIN)] {
            tabs.push(self.view("TextDocument", name, &[entity.to_owned()], &[])?);
        }
        tabs.extend(last);
        self.container(part::ContainerKind::Tabs, &tabs, &[])
    }

    /// The log of all runs' events.
    fn events(&mut self, shown: &[DrawnRun]) -> Result<Node, RecordError> {
        let columns = [TextLogColumnKind::LogLevel, TextLogColumnKind::Body]
            .map(|kind| part::TextLogColumn(TextLogColumn { visible: true.into(), kind }));
        let columns = view::TextLogColumns::new().with_text_log_columns(columns);
        let events: Vec<String> = shown.iter().map(|s| format!("/{}/events", s.root)).collect();
        self.view("TextLog", "events", &events, &[("TextLogColumns", &columns)])
    }

    /// Makes this the layout that the viewer opens with, without its side panels.
    fn activate(mut self, root: &Node, time: &view::TimePanelBlueprint) -> Result<(), RecordError> {
        for panel in ["blueprint_panel", "selection_panel"] {
            self.log(panel, &view::PanelBlueprint::new().with_state(part::PanelState::Hidden))?;
        }
        self.log("time_panel", time)?;
        let viewport = view::ViewportBlueprint::new()
            .with_root_container(part::RootContainer(Uuid { bytes: root.id }))
            .with_auto_layout(false)
            .with_auto_views(false);
        self.log("viewport", &viewport)?;
        self.writer.activate_layout()
    }
}

/// Writes the layout of welds and makes it the active one.
pub(super) fn weld<W: Write>(
    writer: &mut Writer<W>,
    shown: &[DrawnRun],
    exaggeration: f64,
) -> Result<(), RecordError> {
    let mut layout = Layout { writer, count: 0 };
    let cell = cell(&mut layout, shown, exaggeration)?;
    let events = layout.events(shown)?;
    let words = layout.words(Some(events))?;
    let left = layout.container(part::ContainerKind::Vertical, &[cell, words], &[4.0, 1.0])?;

    // The whole weld, on whichever timeline.
    let all = TimeRange { start: TimeRangeBoundary::Infinite, end: TimeRangeBoundary::Infinite };
    let axis = view::TimeAxis::new().with_view_range(all);
    let legend = view::PlotLegend::new().with_corner(part::Corner2D::RightTop);
    // The ripple of the working push, not the ramp to it.
    let push =
        shown.iter().flat_map(|s| s.recording.rows.iter()).filter(|r| r.phase == Phase::Steady);
    let [low, high] = push
        .map(|r| -r.force_w.z / MILLI)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    let push_axis = if low < high {
        let room = high - low;
        view::ScalarAxis::new().with_range(Range1D([low - 0.3 * room, high + 1.4 * room]))
    } else {
        view::ScalarAxis::new()
    };
    // Both limits.
    let limit = shown.first().map_or(0.0, |s| s.recording.half_pin * MILLI);
    let [low, high] = extent(shown, |r| [r.deviation_w.linear.y * MILLI]);
    let lateral_axis = axis_of([low.min(-limit), high.max(limit)]);
    let mut plots = Vec::new();
    for group in GROUPS {
        let runs = shown.iter().enumerate().filter(|(k, s)| match group.of {
            Of::All => true,
            Of::First => *k == 0,
            Of::Compensated => s.recording.compensator != "none",
        });
        let mut contents: Vec<String> = runs
            .flat_map(|(k, s)| {
                let shown_once = move |e: &&&str| !idle(s, e) && (k == 0 || **e != DESIRED);
                group.entities.iter().filter(shown_once).map(|e| format!("/{}/{e}", s.root))
            })
            .collect();
        if contents.is_empty() && !shown.is_empty() {
            continue;
        }
        contents.extend(group.references.iter().map(|e| format!("/reference/{e}")));
        let name = match (group.of, shown.first()) {
            (Of::First, Some(first)) => format!("{}: {}", group.title, first.name),
            _ => group.title.to_owned(),
        };
        let mut properties: Vec<(&str, &dyn AsComponents)> =
            vec![("PlotLegend", &legend), ("TimeAxis", &axis)];
        if group.entities.contains(&DESIRED) {
            properties.push(("ScalarAxis", &push_axis));
        }
        if group.references.contains(&"half_pin") {
            properties.push(("ScalarAxis", &lateral_axis));
        }
        plots.push(layout.view("TimeSeries", &name, &contents, &properties)?);
    }
    let rest = plots.split_off(3.min(plots.len()));
    let tabs = layout.container(part::ContainerKind::Tabs, &rest, &[])?;
    plots.push(tabs);
    let right = layout.container(part::ContainerKind::Vertical, &plots, &[8.5, 4.5, 6.0, 5.0])?;
    let root = layout.container(part::ContainerKind::Horizontal, &[left, right], &[5.0, 4.0])?;

    // Plays the way along the seam, again and again.
    let time = view::TimePanelBlueprint::new()
        .with_state(part::PanelState::Collapsed)
        .with_timeline("time")
        .with_playback_speed(10.0)
        .with_play_state(part::PlayState::Playing)
        .with_loop_mode(part::LoopMode::Selection);
    let time = match shown.first().and_then(steady) {
        Some([from, to]) => {
            let nanoseconds = |s: f64| TimeInt((s * 1e9) as i64);
            time.with_time_selection(AbsoluteTimeRange {
                min: nanoseconds(from),
                max: nanoseconds(to),
            })
        }
        None => time,
    };
    layout.activate(&root, &time)
}

/// Writes the layout of the responses to a step and makes it the active one.
pub(super) fn step<W: Write>(
    writer: &mut Writer<W>,
    shown: &[DrawnRun],
    step: Option<&SetPointStep>,
) -> Result<(), RecordError> {
    let mut layout = Layout { writer, count: 0 };
    // From a little before the step to the end, on the timeline that counts from it.
    let boundary =
        |seconds: f64| TimeRangeBoundary::Absolute(TimeInt((seconds * 1e9).round() as i64));
    let axis = view::TimeAxis::new().with_view_range(TimeRange {
        start: boundary(-BEFORE_STEP),
        end: step
            .map_or(TimeRangeBoundary::Infinite, |s| boundary((1.0 + LEGEND_SHARE) * s.length)),
    });
    let legend = view::PlotLegend::new().with_corner(part::Corner2D::RightTop);
    let whole = view::ScalarAxis::new();
    let near = step.map_or_else(view::ScalarAxis::new, |s| {
        let [low, high] = [-3.0, 3.0].map(|bands| (s.goal + bands * s.near) / MILLI);
        view::ScalarAxis::new().with_range(Range1D([low, high]))
    });
    let mut plot = |name: &str, entities: Vec<String>, y: &view::ScalarAxis| {
        let properties: [(&str, &dyn AsComponents); 3] =
            [("PlotLegend", &legend), ("TimeAxis", &axis), ("ScalarAxis", y)];
        layout.view("TimeSeries", name, &entities, &properties)
    };
    let of_all = |entity: &str| -> Vec<String> {
        shown.iter().filter(|s| !idle(s, entity)).map(|s| format!("/{}/{entity}", s.root)).collect()
    };
    let push = || {
        let mut push = of_all("force/real");
        push.extend(shown.first().map(|s| format!("/{}/{DESIRED}", s.root)));
        push.push(step::SETTLING_BAND_ENTITY.to_owned());
        push
    };
    let response = plot("push [kN], ±5 % of the step", push(), &whole)?;
    let end = plot("the same, near its end value", push(), &near)?;
    let error =
        plot("force error that the controller sees [N]", of_all("controller/force_error"), &whole)?;
    let depth =
        plot("depth that the force loop adds [mm]", of_all("controller/depth_correction"), &whole)?;
    let branch = plot("push that the force branch adds [N]", of_all("controller/push"), &whole)?;
    let mut rows = Vec::new();
    // On one scale, so that the controllers can be compared.
    for (title, entity, [low, high]) in [
        (
            "twist of the drives [mrad]",
            "twist",
            extent::<JOINTS>(shown, |r| (r.torsion() * MILLI).into()),
        ),
        (
            "torque of the motors [kN·m]",
            "torque",
            extent::<JOINTS>(shown, |r| (r.torque / MILLI).into()),
        ),
    ] {
        let room = 0.05 * (high - low);
        let y = view::ScalarAxis::new().with_range(Range1D([low - room, high + room]));
        let plots = shown
            .iter()
            .map(|s| {
                plot(&format!("{title}: {}", s.name), vec![format!("/{}/{entity}", s.root)], &y)
            })
            .collect::<Result<Vec<_>, _>>()?;
        rows.push(plots);
    }
    let events = layout.events(shown)?;
    let words = layout.words(Some(events))?;
    let mut all = vec![
        layout.container(part::ContainerKind::Horizontal, &[response, end, words], &[1.0; 3])?,
        layout.container(part::ContainerKind::Horizontal, &[error, depth, branch], &[1.0; 3])?,
    ];
    for plots in rows.iter().filter(|plots| !plots.is_empty()) {
        all.push(layout.container(
            part::ContainerKind::Horizontal,
            plots,
            &vec![1.0; plots.len()],
        )?);
    }
    let root = layout.container(part::ContainerKind::Vertical, &all, &[4.6, 2.6, 3.9, 3.9])?;
    let time = view::TimePanelBlueprint::new()
        .with_state(part::PanelState::Collapsed)
        .with_timeline(SINCE_STEP)
        .with_play_state(part::PlayState::Paused);
    layout.activate(&root, &time)
}

/// Writes the layout of a part's placements and makes it the active one.
pub(super) fn placed<W: Write>(writer: &mut Writer<W>) -> Result<(), RecordError> {
    let mut layout = Layout { writer, count: 0 };
    let background = view::Background::new(part::BackgroundKind::SolidColor)
        .with_color(Color::from_rgb(244, 245, 247));
    let contents = [super::placed::MAP.to_owned(), format!("{}/**", super::placed::SEAMS)];
    let title = "placements: blue within what is allowed, orange beyond";
    let space = layout.view("3D", title, &contents, &[("Background", &background)])?;
    let words = layout.words(None)?;
    let root = layout.container(part::ContainerKind::Horizontal, &[space, words], &[3.0, 2.0])?;
    let time = view::TimePanelBlueprint::new().with_state(part::PanelState::Hidden);
    layout.activate(&root, &time)
}

/// Writes the layout of a comparison and makes it the active one: the worst channels' differences
/// always seen, the others as tabs.
pub(super) fn compare<W: Write>(
    writer: &mut Writer<W>,
    shown: &[super::compare::ShownLog],
) -> Result<(), RecordError> {
    const CHANNELS_ALWAYS_SHOWN: usize = 4;
    let mut layout = Layout { writer, count: 0 };
    let mut spaces = Vec::new();
    // The way that is furthest off lies on top.
    let mut ways: Vec<_> = shown
        .iter()
        .filter_map(|s| Some((s, s.exaggeration?, s.place()?, s.way_score()?)))
        .collect();
    ways.sort_by(|a, b| b.3.total_cmp(&a.3));
    for (shown, factor, (middle, reach), _) in ways {
        let title = match factor {
            1.0 => format!("{}: tool, to scale", shown.log.name),
            factor => format!("{}: tool, deviations {factor:.0} × too large", shown.log.name),
        };
        let background = view::Background::new(part::BackgroundKind::SolidColor)
            .with_color(Color::from_rgb(244, 245, 247));
        // All of it, seen from beyond it and a little above.
        let outward =
            Vector3::new(middle.x, middle.y, 0.0).try_normalize(1e-6).unwrap_or_else(Vector3::x);
        let away =
            Rotation3::from_axis_angle(&Vector3::z_axis(), 0.7) * outward + Vector3::z() * 0.6;
        let eye = view::EyeControls3D::new()
            .with_position((middle + away * 1.8 * reach.max(1e-3)).map(|v| v as f32).data.0[0])
            .with_look_target(middle.map(|v| v as f32).data.0[0])
            .with_eye_up([0.0, 0.0, 1.0]);
        let properties: [(&str, &dyn AsComponents); 2] =
            [("EyeControls3D", &eye), ("Background", &background)];
        spaces.push(layout.view(
            "3D",
            &title,
            &[format!("/{}/tool/**", shown.root)],
            &properties,
        )?);
    }
    let verdict = match shown.iter().any(|s| s.after.is_some()) {
        true => {
            Some(layout.view("TextLog", "verdict", &[super::compare::VERDICT.to_owned()], &[])?)
        }
        false => None,
    };
    let about = layout.words(verdict)?;
    let left = match spaces.is_empty() {
        true => about,
        false => {
            let tabs = layout.container(part::ContainerKind::Tabs, &spaces, &[])?;
            layout.container(part::ContainerKind::Vertical, &[tabs, about], &[3.0, 2.0])?
        }
    };
    let mut channels: Vec<_> =
        shown.iter().flat_map(|s| s.log.channels.iter().map(move |c| (s, c))).collect();
    channels.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
    let legend = view::PlotLegend::new().with_corner(part::Corner2D::RightTop);
    let mut plots = Vec::new();
    for (shown, channel) in channels {
        // Of two models, one entity each below it.
        let entity = format!("{}/**", shown.difference(&channel.name));
        let time = whole(shown.log);
        let difference = axis_of(shown.extent(channel));
        let properties: [(&str, &dyn AsComponents); 3] =
            [("PlotLegend", &legend), ("TimeAxis", &time), ("ScalarAxis", &difference)];
        plots.push(layout.view("TimeSeries", &shown.title(channel), &[entity], &properties)?);
    }
    let rest = plots.split_off(CHANNELS_ALWAYS_SHOWN.min(plots.len()));
    if !rest.is_empty() {
        plots.push(layout.container(part::ContainerKind::Tabs, &rest, &[])?);
    }
    let shares = vec![1.0; plots.len()];
    let right = layout.container(part::ContainerKind::Vertical, &plots, &shares)?;
    let root = layout.container(part::ContainerKind::Horizontal, &[left, right], &[4.0, 5.0])?;
    let time = view::TimePanelBlueprint::new()
        .with_state(part::PanelState::Collapsed)
        .with_timeline("time")
        .with_play_state(part::PlayState::Paused);
    layout.activate(&root, &time)
}

/// A time axis with all of a log on it, also of one whose rows are minutes apart, and room for the
/// legend.
fn whole(log: &LogComparison) -> view::TimeAxis {
    let ends = log.traces.iter().filter_map(|t| Some([*t.time.first()?, *t.time.last()?]));
    let [start, end] =
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [c, d]| [a.min(c), b.max(d)]);
    if start >= end {
        return view::TimeAxis::new();
    }
    let boundary =
        |seconds: f64| TimeRangeBoundary::Absolute(TimeInt((seconds * 1e9).round() as i64));
    // These plots are wide: the legend takes a tenth of them.
    let end = boundary(end + 0.1 * (end - start));
    view::TimeAxis::new().with_view_range(TimeRange { start: boundary(start), end })
}

/// Smallest and largest of some signals over all runs.
fn extent<const N: usize>(shown: &[DrawnRun], of: impl Fn(&RecordRow) -> [f64; N]) -> [f64; 2] {
    let values = shown.iter().flat_map(|s| s.recording.rows.iter()).flat_map(of);
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// A vertical axis of a range, above it room for the legend; the viewer's own where the range is empty.
fn axis_of([low, high]: [f64; 2]) -> view::ScalarAxis {
    let room = high - low;
    match room > 0.0 {
        true => view::ScalarAxis::new().with_range(Range1D([low - 0.05 * room, high + 0.3 * room])),
        false => view::ScalarAxis::new(),
    }
}

/// First and last instant of the steady part, s.
fn steady(shown: &DrawnRun) -> Option<[f64; 2]> {
    let mut steady = shown.recording.rows.iter().filter(|r| r.phase == Phase::Steady);
    let first = steady.next()?;
    Some([first.time, steady.next_back().unwrap_or(first).time])
}

/// The view in space, its camera beside the seam and looking back at the arm.
fn cell<W: Write>(
    layout: &mut Layout<'_, W>,
    shown: &[DrawnRun],
    exaggeration: f64,
) -> Result<Node, RecordError> {
    let seam = shown.first().and_then(|s| super::scene::DrawnSeam::of(&s.recording.rows));
    let seam = seam.map(|seam| seam.middle());
    let middle = seam.map_or(Vector3::new(1.5, 0.0, 0.5), |(place, _)| place);
    let outward =
        Vector3::new(middle.x, middle.y, 0.0).try_normalize(1e-6).unwrap_or_else(Vector3::x);
    let mut away =
        Rotation3::from_axis_angle(&Vector3::z_axis(), 0.7) * outward * 2.5 + Vector3::z() * 1.7;
    // On the side of the plate that the tool is on, and not along its surface.
    let face = seam.map_or(Vector3::z(), |(_, axes)| -axes.column(2).into_owned());
    away += face * (0.35 * away.norm() - face.dot(&away)).max(0.0);
    let eye = middle + away;
    let target = middle - outward * 0.5 + Vector3::z() * 0.35;
    let eye = view::EyeControls3D::new()
        .with_position(eye.map(|v| v as f32).data.0[0])
        .with_look_target(target.map(|v| v as f32).data.0[0])
        .with_eye_up([0.0, 0.0, 1.0]);
    let grid = view::LineGrid3D::new().with_visible(true).with_spacing(0.5);
    let background = view::Background::new(part::BackgroundKind::SolidColor)
        .with_color(Color::from_rgb(244, 245, 247));
    let title = match exaggeration {
        1.0 => "cell, to scale".to_owned(),
        factor => format!("cell: deviations drawn {factor:.0} × too large"),
    };
    let mut contents = vec!["/cell/**".to_owned()];
    contents.extend(shown.iter().map(|s| format!("/{}/cell/**", s.root)));
    layout.view(
        "3D",
        &title,
        &contents,
        &[("EyeControls3D", &eye), ("LineGrid3D", &grid), ("Background", &background)],
    )
}
