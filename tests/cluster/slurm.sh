#!/usr/bin/env bash
# A real SLURM of one node for tests: `slurm.sh up`, `slurm.sh down`.  Everything it writes is in build/slurm; its clients
# find it by SLURM_CONF=build/slurm/slurm.conf.  No accounting; processes are followed through /proc, none is bound to cores.
set -euo pipefail
cd "$(dirname "$0")/../.."
place="$PWD/build/slurm"
export SLURM_CONF="$place/slurm.conf"

down() {
  # Jobs first: slurmd leaves with its last step, and nobody else would end them.
  if [ -s "$place/slurmctld.pid" ] && timeout 10 scancel --user "$(id -un)" 2>/dev/null; then
    for _ in $(seq 30); do [ -n "$(timeout 10 squeue -h 2>/dev/null)" ] || break; sleep 1; done
  fi
  for name in slurmd slurmctld munged; do
    if [ -s "$place/$name.pid" ]; then kill "$(cat "$place/$name.pid")" 2>/dev/null || true; fi
    rm -f "$place/$name.pid"
  done
}

up() {
  missing=
  for package in slurmctld slurmd slurm-client munge; do
    dpkg-query -W -f '${db:Status-Status}' $package 2>/dev/null | grep -qx installed || missing="$missing $package"
  done
  if [ -n "$missing" ]; then
    sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
    install="$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends$missing"
    $install >&2 || { $sudo apt-get update -q >&2 && $install >&2; }
  fi
  down
  mkdir -p "$place/state" "$place/spool"
  chmod 755 "$place"
  [ -s "$place/munge.key" ] || (umask 077; head -c 1024 /dev/urandom > "$place/munge.key")
  # --force: the checkout may lie in a folder that munge finds too open.
  munged --force --key-file "$place/munge.key" --socket "$place/munge.socket" --pid-file "$place/munged.pid" \
    --log-file "$place/munged.log" --seed-file "$place/munge.seed" 2>> "$place/munged.log"
  host=$(hostname -s)
  cores=$(env -u OMP_NUM_THREADS nproc)  # nproc follows that variable, which make sets to 1
  cat > "$SLURM_CONF" <<END
ClusterName=peen
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$place/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
StateSaveLocation=$place/state
SlurmdSpoolDir=$place/spool
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/slurmd.pid
SlurmctldLogFile=$place/slurmctld.log
SlurmdLogFile=$place/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$(awk '/MemTotal/ {print int($2 / 1024)}' /proc/meminfo) State=UNKNOWN
PartitionName=peen Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
  # Snakemake starts the work of a job by srun without the environment's SLURM_CONF: this one, first on the path, has it.
  mkdir -p "$place/bin"
  printf '#!/bin/sh\nSLURM_CONF=%s exec %s "$@"\n' "'$SLURM_CONF'" "$(command -v srun)" > "$place/bin/srun"
  chmod +x "$place/bin/srun"
  slurmctld -f "$SLURM_CONF"
  slurmd -f "$SLURM_CONF"
  for _ in $(seq 60); do
    if sinfo -h -o %T 2>/dev/null | grep -qx idle; then
      echo "SLURM is up: export SLURM_CONF=$SLURM_CONF PATH=$place/bin:\$PATH"
      return
    fi
    sleep 1
  done
  echo "SLURM did not come up; see the logs in $place" >&2
  tail -n 5 "$place"/*.log >&2
  down
  exit 1
}

case "${1:-}" in
  up) up ;;
  down) down ;;
  *) echo "usage: slurm.sh up | down" >&2; exit 2 ;;
esac
