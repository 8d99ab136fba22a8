#!/usr/bin/env bash
# The exported C on this machine gives the answers of the Rust code to the bit: over the drill of the firmware, with approach rates that
# count at the reference lean and at the firing angle; and over the drill of running, in both types of numbers.
#
#     bash controller/c/check.sh [all] [DECISIONS [CYCLES]]
#
# With `all` also over the drills of learnt tables and of balls, a simulated ball's run, and 20 jumps that robot.c fires in the
# multi-body simulation. Their Rust programs are in studies/, which takes minutes to build.
#
# Ends with 3 where there is no C compiler.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v cc >/dev/null || exit 3
everything=
if [ "${1:-}" = all ]; then
    everything=yes
    shift
fi
decisions=${1:-100000}
cycles=${2:-1000000}
tables=controller/examples/rats_planar
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
build=$target/c-drill
mkdir -p "$build"

# A program of studies/.
study() {
    (cd studies && CARGO_TARGET_DIR=$target cargo run --quiet --release --locked --bin "$1" -- "${@:2}")
}

# The control loop that docs/controller.md shows.
cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -I"$tables" controller/examples/robot.c "$tables/saltus_controller.c" -lm -o "$build/robot"
[ -z "$everything" ] || study in_the_loop 20 "$build/robot" || { printf 'robot.c does not jump as the Rust controller does\n' >&2; exit 1; }

for at_firing in 0 1; do
    sed "s/^#define AT_FIRING .*/#define AT_FIRING $at_firing/" "$tables/saltus_controller.c" >"$build/saltus_controller.c"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DDECISIONS="$decisions" -I"$tables" -Icontroller/firmware \
        controller/firmware/{main,drill}.c "$build/saltus_controller.c" -lm -o "$build/drill"
    # The numbers of the self-test are those of the tables as exported.
    "$build/drill" | grep -v '^self-test' >"$build/c.txt" || true
    cargo run --quiet --release --locked -p saltus-controller --example drill -- "$decisions" "$at_firing" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'the exported C and Rust disagree\n' >&2; exit 1; }
done
cat "$build/rust.txt"
for real in float double; do
    bash controller/c/filled.sh "$real" "$build"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DCYCLES="$cycles" -I"$build" -Icontroller/firmware \
        controller/firmware/running.c "$build/saltus_running.c" -lm -o "$build/running"
    "$build/running" >"$build/c.txt"
    cargo run --quiet --release --locked -p saltus-controller --example running_drill -- "$cycles" "$real" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'running in C and in Rust disagree\n' >&2; exit 1; }
    printf 'running, %s: ' "$real"
    cat "$build/rust.txt"
    [ -n "$everything" ] || continue
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DSTATES="$cycles" -I"$build" -Icontroller/firmware \
        controller/firmware/policy.c -o "$build/policy"
    "$build/policy" >"$build/c.txt"
    study policy_drill "$cycles" "$real" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'learnt tables in C and in Rust disagree\n' >&2; exit 1; }
    printf 'learnt tables, %s: ' "$real"
    cat "$build/rust.txt"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DCYCLES="$cycles" -I"$build" -Icontroller/firmware \
        controller/firmware/ball.c "$build/saltus_ball.c" -lm -o "$build/ball"
    "$build/ball" >"$build/c.txt"
    study ball_drill "$cycles" "$real" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'a ball in C and in Rust disagrees\n' >&2; exit 1; }
    printf 'a ball, %s: ' "$real"
    cat "$build/rust.txt"
    study ball_replay 60 "$real" "$build/replay" >"$build/rust.txt"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -I"$build/replay" -Icontroller/firmware controller/firmware/ball_replay.c \
        "$build/replay/saltus_ball.c" -lm -o "$build/replayed"
    "$build/replayed" >"$build/c.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'a simulated ball in C and in Rust disagrees\n' >&2; exit 1; }
    printf 'a simulated ball, %s: ' "$real"
    cat "$build/rust.txt"
done
printf 'the same to the bit in C and in Rust\n'
