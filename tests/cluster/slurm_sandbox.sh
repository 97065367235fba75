#!/usr/bin/env bash
# A private Slurm cluster (munged + slurmctld + N slurmd) on this machine, as root, without systemd.
#   slurm_sandbox.sh start        start (no-op when already healthy)
#   slurm_sandbox.sh stop [--wipe]  end only what start started (pid + kernel start time), opt. delete the state
#   slurm_sandbox.sh status       one line a daemon, exit 0 when all run
#   slurm_sandbox.sh env          prints `export SLURM_CONF=...`: eval it
#   slurm_sandbox.sh kill-node N | start-node N       kill -9 / start slurmd number N; its tasks live on  (failure tests)
#   slurm_sandbox.sh lose-node N                      kill -9 slurmd number N and all that runs under it
#   slurm_sandbox.sh kill-ctld   | start-ctld         the same for slurmctld (state is kept)
# Settings (environment): SLURM_SANDBOX_DIR (short path!), SLURM_SANDBOX_NODES, SLURM_SANDBOX_CPUS,
#   SLURM_SANDBOX_PORT (first of NODES+2 consecutive ports, loopback only)
set -euo pipefail
D=${SLURM_SANDBOX_DIR:-/tmp/slurm_sandbox}
NODES=${SLURM_SANDBOX_NODES:-3}
CPUS=${SLURM_SANDBOX_CPUS:-2}
PORT=${SLURM_SANDBOX_PORT:-27810}
HOST=$(hostname -s)
export SLURM_CONF=$D/etc/slurm.conf
unset SLURM_JOB_ID SLURM_JOBID || true

die() { echo "slurm_sandbox: $*" >&2; exit 1; }
log() { echo "slurm_sandbox: $*" >&2; }

# --- process bookkeeping: "pid starttime" so that a reused pid is never hit ---
starttime() { local s; s=$(cat "/proc/$1/stat" 2>/dev/null) || return 1; s=${s##*) }; set -- $s; [ "$1" != Z ] || return 1; echo "${20}"; }
alive() { # alive NAME -> prints the pid when it is still our process
  local pid st; [ -s "$D/run/$1.proc" ] || return 1; read -r pid st < "$D/run/$1.proc" || return 1
  [ "$(starttime "$pid" || echo none)" = "$st" ] && echo "$pid"
}
launch() { # launch NAME CMD...   (own session, no inherited lock fd, no stdin)
  local name=$1; shift
  setsid "$@" >>"$D/log/$name.out" 2>&1 </dev/null 9>&- &
  local pid=$!
  echo "$pid $(starttime $pid || echo gone)" > "$D/run/$name.proc"
  disown "$pid" 2>/dev/null || true
}
wait_for() { # wait_for SECONDS WHAT CMD...
  local t_end=$((SECONDS + $1)) what=$2; shift 2
  until "$@" >/dev/null 2>&1; do
    [ $SECONDS -lt $t_end ] || { log "timed out waiting for $what"; return 1; }
    sleep 0.05
  done
}
end() { # end NAME SIGNAL GRACE : SIGNAL, then KILL
  local pid; pid=$(alive "$1") || { rm -f "$D/run/$1.proc"; return 0; }
  kill -"$2" "$pid" 2>/dev/null || true
  local t_end=$((SECONDS + $3))
  while alive "$1" >/dev/null; do
    if [ $SECONDS -ge $t_end ]; then kill -KILL "$pid" 2>/dev/null || true; fi
    sleep 0.05
  done
  rm -f "$D/run/$1.proc"
}

write_config() {
  local last=$((PORT + 1 + NODES))
  cat > "$D/etc/slurm.conf" <<CONF
ClusterName=sandbox
SlurmctldHost=$HOST(127.0.0.1)
SlurmctldPort=$PORT
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
# cred_expire is also the time a requeued job is held back (120 s by default!)
AuthInfo=socket=$D/run/munge.socket,cred_expire=${SLURM_SANDBOX_CRED_EXPIRE:-5}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation=$D/state
SlurmdSpoolDir=$D/spool/%n
# srun --mpi=pmix makes TmpFS/spmix_appdir_*: with the default /tmp two virtual nodes collide (File exists)
TmpFS=$D/tmp/%n
SlurmctldPidFile=$D/run/slurmctld.pid
SlurmdPidFile=$D/run/slurmd.%n.pid
SlurmctldLogFile=$D/log/slurmctld.log
SlurmdLogFile=$D/log/slurmd.%n.log
SlurmctldDebug=info
SlurmdDebug=info
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$D/log/jobcomp.txt
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
# virtual nodes: believe the config, not the hardware
SlurmdParameters=config_overrides
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=2,bf_interval=1,batch_sched_delay=0,sched_min_interval=0
PriorityType=priority/basic
ReturnToService=2
JobRequeue=1
MinJobAge=3600
MaxJobCount=20000
MaxArraySize=10001
KillWait=5
SlurmctldTimeout=10
SlurmdTimeout=10
InactiveLimit=0
CompleteWait=0
MailProg=/bin/true
NodeName=n[1-$NODES] NodeHostname=$HOST NodeAddr=127.0.0.1 Port=[$((PORT + 1))-$((PORT + NODES))] Boards=1 SocketsPerBoard=1 CoresPerSocket=$CPUS ThreadsPerCore=1 RealMemory=4000 State=UNKNOWN
PartitionName=debug Nodes=n[1-$NODES] Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
CONF
  # 22.05 has no CgroupPlugin=disabled (23.02 has); v1 only reads its config here, v2 would want systemd + dbus
  echo 'CgroupPlugin=cgroup/v1' > "$D/etc/cgroup.conf"
}

start_munge() {
  alive munged >/dev/null && return 0
  rm -f "$D/run/munge.socket" "$D/run/munge.socket.lock" "$D/run/munge.pid"
  [ -s "$D/etc/munge.key" ] || { (umask 077; head -c 1024 /dev/urandom > "$D/etc/munge.key"); }
  launch munged munged --foreground --force --key-file="$D/etc/munge.key" --socket="$D/run/munge.socket" \
    --pid-file="$D/run/munge.pid" --log-file="$D/log/munged.log" --seed-file="$D/state/munge.seed" --origin=127.0.0.1
  wait_for 10 munged test -S "$D/run/munge.socket" || { tail -n 5 "$D/log/munged.out" "$D/log/munged.log" >&2; return 1; }
}
start_ctld() {
  alive slurmctld >/dev/null && return 0
  launch slurmctld slurmctld -D -f "$SLURM_CONF"
  wait_for 20 slurmctld sh -c 'scontrol ping | grep -q "is UP"' || { tail -n 20 "$D/log/slurmctld.log" "$D/log/slurmctld.out" >&2; return 1; }
}
start_node() {
  alive "slurmd.n$1" >/dev/null && return 0
  mkdir -p "$D/spool/n$1" "$D/tmp/n$1"
  launch "slurmd.n$1" slurmd -D -N "n$1" -f "$SLURM_CONF"
}
all_up() { [ "$(sinfo -h -N -o '%T' 2>/dev/null | grep -cE '^(idle|mixed|allocated|completing)$')" = "$NODES" ]; }
all_up_or_dead() { all_up || ! running; } # ends the wait at once when a daemon died
names() { echo munged slurmctld; for i in $(seq "$NODES"); do echo "slurmd.n$i"; done; }
running() { local n; for n in $(names); do alive "$n" >/dev/null || return 1; done; }

# slurmstepd processes of this sandbox: their listening step socket lies in our spool folder.
stepd_pids() {
  local p
  for p in /proc/[0-9]*; do
    case $(readlink "$p/exe" 2>/dev/null) in */slurmstepd*) ;; *) continue ;; esac
    if tr '\0' '\n' < "$p/environ" 2>/dev/null | grep -qx "SLURM_CONF=$SLURM_CONF"; then echo "${p#/proc/}"
    elif readlink "$p/cwd" "$p"/fd/* 2>/dev/null | grep -q "^$D/"; then echo "${p#/proc/}"; fi
  done
}

descendants() { # the given pids and everything below them
  local p kids
  for p in "$@"; do echo "$p"; kids=$(cat "/proc/$p/task"/*/children 2>/dev/null || true); [ -z "$kids" ] || descendants $kids; done
}

cmd_start() {
  local t0=$EPOCHREALTIME n i
  for n in munged slurmctld slurmd scontrol sinfo; do command -v $n >/dev/null || die "$n is missing: apt-get install -y --no-install-recommends slurm-wlm munge"; done
  [ "$(id -u)" = 0 ] || die "must be root"
  [ ${#D} -le 60 ] || die "SLURM_SANDBOX_DIR is too long for unix sockets: $D"
  case $(getent ahostsv4 "$HOST" | awk 'NR==1{print $1}') in 127.*) ;; *) die "the host name $HOST must resolve to loopback: echo '127.0.0.1 $HOST' >> /etc/hosts" ;; esac
  if running && all_up; then log "already running ($D)"; return 0; fi
  chmod 755 "$D"; mkdir -p "$D"/{etc,run,log,state,spool,tmp}; chmod 755 "$D"/{etc,run,log}; chmod 700 "$D/state"
  if ! alive slurmctld >/dev/null; then write_config; fi
  start_munge || { cmd_stop; die "munged did not start"; }
  start_ctld  || { cmd_stop; die "slurmctld did not start"; }
  for i in $(seq "$NODES"); do start_node "$i"; done
  wait_for 30 "all nodes idle" all_up_or_dead && all_up || { sinfo -N -l >&2; tail -n 5 "$D"/log/slurmd.n*.log "$D"/log/slurmd.n*.out >&2; cmd_stop; die "nodes did not come up"; }
  log "up: $NODES nodes x $CPUS CPUs after $(awk -v a="$t0" -v b="$EPOCHREALTIME" 'BEGIN{printf "%.2f", b-a}') s ($D)"
}
cmd_stop() {
  local n pid t_end left
  if alive slurmctld >/dev/null && alive munged >/dev/null; then
    # end jobs while the daemons can still do it
    squeue -h -o %A 2>/dev/null | sort -u | xargs -r timeout 10 scancel --full -s KILL 2>/dev/null || true
    squeue -h -o %A 2>/dev/null | sort -u | xargs -r timeout 10 scancel 2>/dev/null || true
    t_end=$((SECONDS + 8))
    while [ $SECONDS -lt $t_end ] && [ -n "$(timeout 5 squeue -h -o %A -t R,CG,CF,S 2>/dev/null || true)" ]; do sleep 0.1; done
  fi
  for n in $(cd "$D/run" 2>/dev/null && ls slurmd.n*.proc 2>/dev/null | sed 's/\.proc$//'); do end "$n" TERM 5; done
  # after a crash of the daemons: their slurmstepd and the job processes under them still run
  left=$(stepd_pids); if [ -n "$left" ]; then left=$(descendants $left); log "ending left-over job processes:" $left; kill -KILL $left 2>/dev/null || true; fi
  end slurmctld TERM 10
  end munged TERM 5
  if [ "${1:-}" = --wipe ]; then case $D in /tmp/?*|/var/tmp/?*|"${TMPDIR:-/tmp}"/?*) rm -rf -- "$D" ;; *) log "not wiping $D (not a temp folder)" ;; esac; fi
  log "stopped"
}
cmd_lose_node() { # stepds of node N: their working folder or an open file lies in its spool folder
  local p left=''
  end "slurmd.n$1" KILL 0
  for p in $(stepd_pids); do
    if readlink "/proc/$p/cwd" /proc/$p/fd/* 2>/dev/null | grep -q "^$D/spool/n$1\(/\|$\)"; then left="$left $p"; fi
  done
  [ -n "$left" ] || { log "nothing runs under node $1"; return 0; }
  left=$(descendants $left); log "ending with node $1:" $left; kill -KILL $left 2>/dev/null || true
}
cmd_status() { local n pid rc=0; for n in $(names); do if pid=$(alive "$n"); then echo "$n running pid $pid"; else echo "$n not running"; rc=1; fi; done; return $rc; }

mkdir -p "$D/run"; chmod 755 "$D" "$D/run"
exec 9>"$D/run/lock"; flock -w 120 9 || die "another slurm_sandbox.sh holds $D/run/lock"
case ${1:-} in
  start) cmd_start ;;
  stop) cmd_stop "${2:-}" ;;
  status) cmd_status ;;
  env) echo "export SLURM_CONF=$SLURM_CONF" ;;
  kill-node) end "slurmd.n$2" KILL 0 ;;
  lose-node) cmd_lose_node "$2" ;;
  start-node) start_node "$2" ;;
  kill-ctld) end slurmctld KILL 0 ;;
  start-ctld) start_ctld ;;
  *) sed -n '2,12p' "$0"; exit 2 ;;
esac
