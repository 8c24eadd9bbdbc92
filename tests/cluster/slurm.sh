#!/bin/bash
# The array recipe on a real Slurm of one node: a task is signalled and requeued, and the merged bytes are those of one
# process. As root on Debian: apt-get install slurm-wlm munge; then LEAFWISE=path/to/leafwise bash tests/cluster/slurm.sh.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
leafwise=$(realpath "${LEAFWISE:-$here/../../target/release/leafwise}")
if ! command -v slurmctld >/dev/null || ! command -v munged >/dev/null; then
    echo "LEFT OUT: slurm-wlm and munge are not installed; the shards of tests/cluster/tasks.sh run as array tasks would" >&2
    exit 77
fi
work=$(mktemp -d)
host=$(hostname -s)
# Ends every daemon and waits for it, the steps of jobs too, so that nothing writes into what is removed.
end() {
    local daemon child
    scancel --user=root 2>/dev/null || true
    for daemon in slurmd slurmctld; do
        child=$(cat "$work/$daemon.pid" 2>/dev/null || true)
        [ -n "$child" ] || continue
        kill "$child" 2>/dev/null || true
        while kill -0 "$child" 2>/dev/null; do sleep 0.1; done
    done
    if [ -n "${munged:-}" ]; then
        kill "$munged" 2>/dev/null || true
        wait "$munged" 2>/dev/null || true
    fi
    rm -rf "$work"
}
trap end EXIT
mkdir -p "$work"/{state,spool} /run/munge /etc/munge
[ -s /etc/munge/munge.key ] || head -c 1024 /dev/urandom >/etc/munge/munge.key
chown -R munge /etc/munge /run/munge /var/log/munge /var/lib/munge
chmod 400 /etc/munge/munge.key
setpriv --reuid=munge --regid=munge --clear-groups munged --foreground --force >"$work/munged.log" 2>&1 &
munged=$!
export SLURM_CONF=$work/slurm.conf
memory=$(awk '/MemAvailable/ { print int($2 / 2048) }' /proc/meminfo)
cat >"$SLURM_CONF" <<CONF
ClusterName=leafwise
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
MpiDefault=none
ReturnToService=2
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
until munge -n >/dev/null 2>&1; do sleep 0.2; done
slurmctld
slurmd
echo "slurmctld and slurmd are started"
until sinfo --noheader --format=%T 2>/dev/null | grep -q idle; do sleep 0.5; done

cd "$work"
cp "$here/cloud.toml" .
PATH=$(dirname "$leafwise"):$PATH
export PATH SCENE=cloud.toml OUT=shards
# Seconds a task.
sed -i 's/^steps *=.*/steps   = 4000/' cloud.toml
leafwise ensemble cloud.toml --out whole --quiet
shards=8
job=$(sbatch --parsable --array=1-$shards --output="$work/task-%a.log" "$here/array.sbatch")
echo "array $job of $shards tasks"
# A task that steps is told to go.
task=""
until [ -n "$task" ]; do
    if [ -z "$(squeue --noheader --jobs="$job")" ]; then
        echo "every task had ended before one was told to go: take more steps" >&2
        exit 1
    fi
    for number in $(seq 1 $shards); do
        if [ -e "shards/shard-$number-of-$shards/checkpoint.bin" ] &&
            grep -q '"outcome": "running"' "shards/shard-$number-of-$shards/manifest.json"; then
            task=$number
        fi
    done
    sleep 0.05
done
id=$(squeue --noheader --jobs="${job}_$task" --format=%A)
# It asks again and again, of a task that is on its way back into the queue.
timeout 3 scancel --signal=TERM --batch "$id" 2>/dev/null || true
echo "task $task is told to go"
# A task that was requeued waits two minutes, unless it is told not to.
until [ -z "$(squeue --noheader --jobs="$job" 2>/dev/null)" ]; do
    scontrol update "JobId=$id" StartTime=now 2>/dev/null || true
    sleep 0.5
done
cat "$work"/task-*.log
grep -q "with a checkpoint: the same command goes on" "$work/task-$task.log"
leafwise merge shards --out merged --quiet
for file in statistics.csv windows.csv final_states.csv; do cmp "whole/$file" "merged/$file"; done
echo "the array's bytes are those of one process; task $task was signalled and requeued"
