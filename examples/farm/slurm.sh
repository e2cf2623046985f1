#!/bin/bash
# A Slurm cluster on this machine alone, to try the files of this folder: munged, slurmctld, and a slurmd for each node, as the user who starts it.
# Debian and Ubuntu have the programs in `slurm-wlm` and `munge`.
#   slurm.sh start DIR [NODES]   starts it, 3 nodes by default; then `export SLURM_CONF=DIR/slurm.conf`, and use sbatch, squeue and scontrol
#   slurm.sh lose DIR NODE       ends a node at once, with all that runs on it, as if its power failed
#   slurm.sh stop DIR            ends it
# Each node claims the cores, the memory and the GPU that the files ask for. So the tasks share what the machine has.
set -eu
PATH=$PATH:/usr/sbin:/sbin
usage() {
    sed -n '2,7s/^# \{0,1\}//p' "$0" >&2
    exit 2
}
[ $# -ge 2 ] || usage
verb=$1
mkdir -p "$2"
dir=$(cd "$2" && pwd)

# Ends the process of a pid file, and waits for it.
finish() {
    local pid
    pid=$(cat "$1" 2>/dev/null) || return 0
    for _ in $(seq 100); do
        kill -TERM "$pid" 2>/dev/null || return 0
        sleep 0.1
    done
    kill -KILL "$pid" 2>/dev/null || true
}

# The processes of a node: first slurmd and slurmstepd, which have its log open, then the tasks, to which Slurm tells its name.
processes() {
    local environs
    find /proc/[0-9]*/fd -lname "$dir/$1.log" 2>/dev/null | cut -d / -f 3 | sort -u
    environs=$(grep -lzxF "SLURM_CONF=$dir/slurm.conf" /proc/[0-9]*/environ 2>/dev/null) || true
    # shellcheck disable=SC2086
    [ -z "$environs" ] || grep -lzxF "SLURMD_NODENAME=$1" $environs 2>/dev/null | cut -d / -f 3
}

# Ends a node, until nothing of it is left.
end_node() {
    local pids
    while pids=$(processes "$1") && [ -n "$pids" ]; do
        # shellcheck disable=SC2086
        kill -KILL $pids 2>/dev/null || true
        sleep 0.1
    done
}

start() {
    local nodes=${1:-3} host first
    for program in munged slurmctld slurmd sbatch; do
        command -v $program >/dev/null || { echo "there is no $program: sudo apt-get install slurm-wlm munge" >&2; exit 3; }
    done
    host=$(hostname -s)
    # Ports of their own for each cluster: three clusters may run side by side.
    first=$((20000 + ($$ % 400) * 100))
    mkdir -p "$dir/state" "$dir/munge"
    chmod 700 "$dir/munge"
    (umask 077 && head -c 128 /dev/urandom >"$dir/munge/key")
    cat >"$dir/slurm.conf" <<CONF
ClusterName=raxel
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$first
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket,cred_expire=5
CryptoType=crypto/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool-%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/%n.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
ReturnToService=2
SlurmdTimeout=10
KillWait=2
GresTypes=gpu
NodeName=n[1-$nodes] NodeHostname=$host NodeAddr=127.0.0.1 Port=[$((first + 1))-$((first + nodes))] CPUs=8 RealMemory=4096 Gres=gpu:1
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    echo "Name=gpu File=/dev/null" >"$dir/gres.conf"
    printf 'CgroupAutomount=no\n' >"$dir/cgroup.conf"
    munged --force --socket="$dir/munge/socket" --key-file="$dir/munge/key" --pid-file="$dir/munge/pid" \
        --log-file="$dir/munge/log" --seed-file="$dir/munge/seed"
    export SLURM_CONF=$dir/slurm.conf
    slurmctld -f "$SLURM_CONF"
    local node
    for node in $(seq "$nodes"); do
        mkdir -p "$dir/spool-n$node"
        slurmd -f "$SLURM_CONF" -N "n$node"
    done
    for _ in $(seq 150); do
        [ "$(sinfo --noheader --Node --states=idle --format=%N 2>/dev/null | sort -u | wc -l)" -eq "$nodes" ] && return 0
        sleep 0.2
    done
    sinfo --Node --long >&2 || true
    echo "the cluster does not start; its logs are in $dir" >&2
    stop
    exit 1
}

stop() {
    local spool
    for spool in "$dir"/spool-*; do
        end_node "${spool##*/spool-}"
    done
    finish "$dir/slurmctld.pid"
    finish "$dir/munge/pid"
}

case $verb in
    start) start "${3:-3}" ;;
    lose)
        [ $# -eq 3 ] || usage
        end_node "$3"
        ;;
    stop) stop ;;
    *) usage ;;
esac
