"""Certifies a law on the workers of a Dask cluster: one shard a task, merged here.

    python3 certify_dask.py --shards 20 --folder shards -- --compensator seam-tracking --trials 1000

What stands behind `--` are the options of `trueweld certify`. Workers and this script share a file
system, as the nodes of a cluster do. Without --scheduler the workers are started here, on loopback.
A worker that is lost has its shard begun again elsewhere; a shard goes on from what is in its folder.
"""

import argparse
import subprocess
import sys
from pathlib import Path

from dask.distributed import Client, LocalCluster, as_completed


def make(program, options, shard, of, folder):
    """Makes one shard, on a worker."""
    command = [program, "certify", *options, "--shard", f"{shard}/{of}", "--evidence", folder]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"shard {shard}/{of}: {done.stderr}")
    return done.stdout.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--shards", type=int, required=True, help="how many parts")
    parser.add_argument("--folder", type=Path, required=True, help="where each shard has its folder")
    parser.add_argument("--program", default="trueweld")
    parser.add_argument("--scheduler", help="address of a Dask scheduler")
    parser.add_argument("--workers", type=int, help="without a scheduler: how many, on loopback")
    parser.add_argument("options", nargs="+", help="of `trueweld certify`, behind --")
    given = parser.parse_args()

    # Where the merged evidence goes is no business of a shard.
    options, merging = list(given.options), list(given.options)
    if "--evidence" in options:
        at = options.index("--evidence")
        del options[at : at + 2]
    folders = [str(given.folder.resolve() / str(shard)) for shard in range(1, given.shards + 1)]

    cluster = None
    if not given.scheduler:
        # No dashboard: nothing listens but on loopback.
        cluster = LocalCluster(
            n_workers=given.workers, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        )
    with Client(given.scheduler or cluster) as client:
        parts = [
            client.submit(make, given.program, options, shard, given.shards, folder, retries=2, pure=False)
            for shard, folder in enumerate(folders, start=1)
        ]
        for part in as_completed(parts):
            print(part.result(), flush=True)
    if cluster:
        cluster.close()
    return subprocess.run([given.program, "certify", *merging, "--merge", *folders]).returncode


if __name__ == "__main__":
    sys.exit(main())
