#!/usr/bin/env bash
# A sweep of 50 x 20 settings against one process a setting: the same numbers, and how many times faster.
#   cargo build --release && tests/cluster/sweep.sh [PROCESSES]; LEAFWISE=PATH names another build
# PROCESSES of the 1000 settings are run alone, spread over the grid, all where not said.
set -euo pipefail
cd "$(dirname "$0")/../.."
leafwise=$(realpath "${LEAFWISE:-target/release/leafwise}")
scene=$PWD/scenes/rigid_body_sweep.toml
processes=${1:-1000}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cd "$out"

seconds() { date +%s.%N; }
begin=$(seconds)
"$leafwise" sweep "$scene" --out sweep --quiet
end=$(seconds)
one=$(awk "BEGIN { print $end - $begin }")

stride=$((1000 / processes))
mapfile -t rows < <(tail -n +2 sweep/sweep.csv | awk "NR % $stride == 0")
begin=$(seconds)
for row in "${rows[@]}"; do
    IFS=, read -r _ inertia step _ <<<"$row"
    "$leafwise" run "$scene" --out run --force --quiet --set system.parameters.I2="$inertia" --set method.time-step="$step" \
        --set method.chosen-at.I2=0.75
    tail -n 1 run/samples.csv >>ends
done
end=$(seconds)
each=$(awk "BEGIN { print ($end - $begin) / ${#rows[@]} }")

# The energies at the end, of samples and of the table.
for row in "${rows[@]}"; do cut -d, -f9 <<<"$row"; done >energies
cut -d, -f5 ends | cmp - energies
awk "BEGIN {
    printf \"one sweep of 1000 settings: %.3f s\n\", $one
    printf \"one process a setting: %.4f s each, %.1f s for 1000 (measured: ${#rows[@]})\n\", $each, 1000 * $each
    printf \"ratio: %.0f\n\", 1000 * $each / $one
}"
