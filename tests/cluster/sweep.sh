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

# Seconds on the clock, and of processors.
TIMEFORMAT='%R %U %S'
{ time "$leafwise" sweep "$scene" --out sweep --quiet; } 2>one

stride=$((1000 / processes))
mapfile -t rows < <(tail -n +2 sweep/sweep.csv | awk "NR % $stride == 0")
each() {
    for row in "${rows[@]}"; do
        IFS=, read -r _ inertia step _ <<<"$row"
        "$leafwise" run "$scene" --out run --force --quiet --set system.parameters.I2="$inertia" \
            --set method.time-step="$step" --set method.chosen-at.I2=0.75
        tail -n 1 run/samples.csv >>ends
    done
}
{ time each; } 2>many

# The energies at the end, of samples and of the table.
printf '%s\n' "${rows[@]}" | cut -d, -f9 >energies
cut -d, -f5 ends | cmp - energies
paste -d' ' one many | awk -v count="${#rows[@]}" '{
    printf "one sweep of 1000 settings: %.2f s, %.2f s of processors\n", $1, $2 + $3
    printf "one process a setting: %.4f s each, %.4f s of processors (%d measured)\n", $4 / count, ($5 + $6) / count, count
    printf "ratio: %.0f, of processors %.0f\n", 1000 * $4 / count / $1, 1000 * ($5 + $6) / count / ($2 + $3)
}'
