#!/usr/bin/env bash
# `niji farm` on a real Slurm: one node on the loopback, as root, without systemd or cgroups.
#   slurm.sh NIJI FOLDER    FOLDER holds what tests/farm/run.sh made: scenes, and in `one` what one run makes of them
set -euo pipefail
niji=$(realpath "$1") work=$(realpath "$2") host=$(hostname -s)
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=SCRIPTDIR/tools.sh
. "$here/tools.sh"
etc=$work/slurm
mkdir -p "$etc"/{state,spool}

# Ends what was started here, each by its own number, the last one first.
started=()
trap 'for ((i = ${#started[@]} - 1; i >= 0; i--)); do kill "${started[i]}" 2>/dev/null || true; done; wait' EXIT

(umask 077 && dd if=/dev/urandom of="$etc/munge.key" bs=128 count=1 status=none)
munged --foreground --force --key-file="$etc/munge.key" --socket="$etc/munge.socket" --pid-file="$etc/munged.pid" \
    --log-file="$etc/munged.log" --seed-file="$etc/munge.seed" --num-threads=2 >"$etc/munged.out" 2>&1 &
started+=($!)
cat >"$etc/slurm.conf" <<CONF
ClusterName=niji
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$etc/munge.socket
CredType=cred/munge
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$etc/state
SlurmdSpoolDir=$etc/spool
SlurmctldPidFile=$etc/slurmctld.pid
SlurmdPidFile=$etc/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=1000
ReturnToService=2
MaxArraySize=3
MinJobAge=3600
KillWait=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=2000
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$etc/slurm.conf
until_true 5 test -S "$etc/munge.socket"
slurmctld -D -c >"$etc/slurmctld.log" 2>&1 &
started+=($!)
slurmd -D -c >"$etc/slurmd.log" 2>&1 &
started+=($!)
is_up() { sinfo -h -o %t 2>/dev/null | grep -q idle; }
until_true 20 is_up

is_idle() { [ -z "$(squeue -h)" ]; }
state() { scontrol -o show job "$1" | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p' | sort -u | tr '\n' ' '; }
# The job of a step, of those that submit.sh printed.
job() { sed -n "s/^$1 //p" "$work/jobs"; }
expect() { # WHAT FOUND EXPECTED
    [ "$2" = "$3" ] || { echo "slurm: $1: found '$2', expected '$3'" >&2; exit 1; }
}
farm() { "$niji" farm "$@" --engine slurm --threads 1 --memory 500MiB --submit -q | tee "$work/jobs"; }

echo "slurm: a task is killed, its frames are named and made again"
cat >"$work/killed-once" <<SH
#!/bin/bash
# The program, killed once with its first frame of 4-6 done.
case "\$*" in *"--frames 4-6 "*) ;; *) exec "$niji" "\$@" ;; esac
mkdir "$work/was-killed" 2>/dev/null || exec "$niji" "\$@"
"$niji" "\$@" &
until [ -s "$work/a b/image.0004.exr" ]; do :; done
kill -9 \$!
wait \$!
SH
chmod +x "$work/killed-once"
scontrol update NodeName="$host" State=DRAIN Reason=test
out="$work/a b" # a name that has to be quoted
NIJI=$work/killed-once farm "$work/sequence.toml" -o "$out" --frames 1-12 --chunk 3
frames=$(job frames) check=$(job check) # with two arrays of them: MaxArraySize is 3
expect "arrays" "$frames" "$(($(job tables) + 1)):$(($(job tables) + 2))"
expect "on a drained node" "$(state "$(job tables)")" "PENDING "
scontrol update NodeName="$host" State=RESUME
until_true 60 is_idle
expect "the killed task" "$(state "${frames%:*}_1")" "FAILED "
expect "its neighbor" "$(state "${frames%:*}_0")" "COMPLETED "
expect "the other array" "$(state "${frames#*:}")" "COMPLETED "
expect "the check of a killed frame" "$(state "$check")" "FAILED "
left=$(left_in "$out")
case $left in 4-6 | 5-6) ;; *) echo "slurm: found '$left' to be made again" >&2; exit 1 ;; esac
for task in "${frames%:*}_1" "${check}_0"; do
    scontrol requeue "$task"
    scontrol update JobId="$task" StartTime=now # else it waits for two minutes
    until_true 60 is_idle
    expect "$task requeued" "$(state "$task")" "COMPLETED "
done
same "$work/one" "$out"

echo "slurm: a frame is gone, one is damaged"
lose "$out"
left=$(left_in "$out")
expect "frames to make again" "$left" "5,9"
NIJI=$niji farm "$work/sequence.toml" -o "$out" --frames "$left" --force
until_true 60 is_idle
expect "the check" "$(state "$(job check)")" "COMPLETED "
same "$work/one" "$out"

echo "slurm: a picture in tiles"
NIJI=$niji farm "$work/picture.toml" -o "$work/tiles" --tiles 8
until_true 60 is_idle
expect "the check of tiles" "$(state "$(job check)")" "COMPLETED "
same "$work/one-picture" "$work/tiles"

echo "slurm: what always fails ends"
for fails in "--frames 7-9 " "--until tables "; do
    printf '#!/bin/bash\ncase "$*" in *"%s"*) exit 1 ;; esac\nexec "%s" "$@"\n' "$fails" "$niji" >"$work/fails"
    chmod +x "$work/fails"
    rm -rf "$work/failing"
    NIJI=$work/fails farm "$work/sequence.toml" -o "$work/failing" --frames 1-12 --chunk 3
    until_true 60 is_idle
    expect "the check of $fails" "$(state "$(job check)")" "FAILED "
    left=$(left_in "$work/failing")
    case $fails in
        *frames*) expect "frames that failed" "$left" "7-9" ;;
        *) expect "frames without tables" "$left $(state "$(job frames | sed 's/:.*//')")" "1-12 CANCELLED " ;;
    esac
done
echo "slurm: done"
