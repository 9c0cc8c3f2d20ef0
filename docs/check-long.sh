#!/usr/bin/env bash
# Runs every command in README.md and docs/*.md, also those marked as long, and compares the figures
# shown with those printed. About an hour on two cores.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo test --release -p trueweld-cli --test all docs:: -- --ignored
