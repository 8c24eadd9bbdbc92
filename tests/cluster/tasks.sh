#!/bin/bash
# Many shards in random order on several processes, a twentieth of them killed while they step and started again, and the merged bytes
# those of one process: LEAFWISE=path/to/leafwise bash tests/cluster/tasks.sh [MEMBERS [SHARDS [PROCESSES]]]. Tasks know themselves by the
# variables of a Slurm array; any other engine, as xargs here, may name them by I/N.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
leafwise=$(realpath "${LEAFWISE:-$here/../../target/release/leafwise}")
members=${1:-20000} shards=${2:-50} processes=${3:-2}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
cp "$here/cloud.toml" .
scene=(cloud.toml --set "ensemble.members=$members")
"$leafwise" ensemble "${scene[@]}" --out whole --quiet

task() {
    local number=$1 shards=$2 child directory
    directory=shards/shard-$(printf '%0*d' "${#shards}" "$number")-of-$shards
    shift 2
    export SLURM_ARRAY_TASK_ID=$number
    # One in twenty is killed while it steps, and its task started again, as an engine does that loses a node. A shard that has come to
    # its end before the blow is begun anew.
    if [ $((number % 20)) -eq 1 ]; then
        for _ in $(seq 100); do
            rm -rf "$directory"
            "$@" --shard "slurm/$shards" --quiet &
            child=$!
            until [ -e "$directory/checkpoint.bin" ] || ! kill -0 "$child" 2>/dev/null; do sleep 0.001; done
            kill -KILL "$child" 2>/dev/null || true
            wait "$child" || true
            if grep -qs '"outcome": "running"' "$directory/manifest.json"; then
                echo "$number" >>killed
                break
            fi
        done
    fi
    "$@" --shard "slurm/$shards" --quiet
}
export -f task
begun=$(date +%s.%N)
seq 1 "$shards" | shuf |
    xargs -P "$processes" -I{} bash -c 'task "$@" 2>>tasks.log' _ {} "$shards" "$leafwise" ensemble "${scene[@]}" --threads 1 --out shards
stepped=$(date +%s.%N)
# Within 200 MB, whatever the number of shards.
(ulimit -v 200000 && exec "$leafwise" merge shards --out merged --quiet)
merged=$(date +%s.%N)
for file in statistics.csv windows.csv final_states.csv; do cmp "whole/$file" "merged/$file"; done
if [ ! -s killed ]; then
    echo "no shard was killed while it stepped: take more members or fewer shards" >&2
    exit 1
fi
killed=$(wc -l <killed)
awk -v m="$members" -v s="$shards" -v p="$processes" -v k="$killed" -v a="$begun" -v b="$stepped" -v c="$merged" 'BEGIN {
    printf "%d members in %d shards on %d processes, %d killed and started again: %.1f s, merged in %.2f s and 200 MB, to the bytes of one process\n",
        m, s, p, k, b - a, c - b }'
