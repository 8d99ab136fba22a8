#!/usr/bin/env bash
# The multi-body simulation and MuJoCo on the same robot, one after the other, twice: bench/multibody.sh [LAUNCHES]
# MuJoCo is installed into target/mujoco, as bench/mujoco_speed.py says.
set -euo pipefail
cd "$(dirname "$0")/.."
launches=${1:-3}
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
(cd studies && CARGO_TARGET_DIR=$target cargo build --quiet --release --bin work_precision)
cargo build --quiet --release -p saltus-cli
for _ in 1 2; do
    "$target/release/work_precision"
    target/mujoco/bin/python bench/mujoco_speed.py --binaries "$target/release" --launches "$launches"
done
