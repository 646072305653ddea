#!/bin/sh
# `facebaker farm --slurm` on a cluster of this one machine: an array job bakes what is not done, a failure is shown, and
# the same command submits it again. Then facebaker-mpi, if it was built, on two ranks that Slurm starts.
#   tests/farm/slurm.sh [BUILD]
# BUILD (build/release) has facebaker, rig_toy and rig_faulty. Installs Slurm and munge, from Debian, if they are missing;
# starts their daemons where none answer, for which it has to be root, and ends those that it has started. Takes a minute.
set -eu
cd "$(dirname "$0")/../.."
build=$(realpath "${1:-build/release}")
tool=$build/bin/facebaker toy=$build/lib/rigs/librig_toy.so faulty=$build/tests/bake/faulty_rig/librig_faulty.so
if ! command -v slurmctld > /dev/null || ! command -v munged > /dev/null; then
  apt-get install -y --no-install-recommends slurm-wlm munge
fi
folder=$(mktemp -d)
chmod 755 "$folder"
started=
clean_up() {
  for pid in $started; do kill "$pid" 2> /dev/null || true; done
  wait
  rm -rf "$folder"
}
trap clean_up EXIT
fail() {
  echo "FAILED: $1" >&2
  tail -n 20 "$folder"/*.log "$folder"/faces/*.out 2> /dev/null >&2 || true
  exit 1
}
# wait_for WORDS COMMAND...: until the command succeeds.
wait_for() {
  what=$1
  shift
  for _ in $(seq 300); do "$@" > /dev/null 2>&1 && return; sleep 0.2; done
  fail "$what"
}

export SLURM_CONF="${SLURM_CONF:-$folder/slurm.conf}"
if [ ! -e "$SLURM_CONF" ]; then
  [ "$(id -u)" = 0 ] || fail "Slurm does not run here, and only root can start it"
  machine=$(hostname -s)
  mkdir -p "$folder/state" "$folder/spool" /run/munge
  cat > "$SLURM_CONF" << END
ClusterName=farm
SlurmctldHost=$machine(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
ReturnToService=2
SlurmdParameters=config_overrides
NodeName=$machine NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$machine Default=YES MaxTime=INFINITE State=UP OverSubscribe=YES
END
  if ! munge -n > /dev/null 2>&1; then
    [ -e /etc/munge/munge.key ] || fail "munge has no key"
    chown munge: /run/munge
    su -s /bin/sh munge -c "exec munged --foreground" > "$folder/munged.log" 2>&1 &
    started="$started $!"
    wait_for "munge does not answer" munge -n
  fi
  slurmctld -D > "$folder/slurmctld.out" 2>&1 &
  started="$started $!"
  slurmd -D > "$folder/slurmd.out" 2>&1 &
  started="$started $!"
fi
wait_for "Slurm does not answer" sh -c "sinfo --noheader --format=%t | grep -qE 'idle|mix|alloc'"

cd "$folder"
options="--recipe linear --poses 60 --use variant"
cat > characters.txt << END
# two that bake, and one whose rig is not there yet
toy=$toy $options
"second"=$toy $options --seed 7   # another seed
late=$folder/librig_late.so $options
END
job_is_over() { [ -z "$(squeue --noheader --jobs="$(cut -d';' -f1 faces/farm.job)" 2> /dev/null)" ]; }
state() { awk -F'|' -v name="$1" '{ gsub(/ /, "") } $2 == name { print $3 }' table; }

echo "an array job bakes what can be baked"
"$tool" farm characters.txt --out faces --slurm --jobs 2 --sbatch "--time=10 --cpus-per-task=1"
grep -qx "#SBATCH --array=0-2%2" faces/farm.sbatch
wait_for "the job does not end" job_is_over
if "$tool" farm characters.txt --out faces --status > table 2> log; then fail "a missing rig was baked"; fi
cat table
[ "$(state toy)" = done ] && [ "$(state second)" = done ] && [ "$(state late)" = failed ] || fail "states are wrong"
grep -q "librig_late.so" table || fail "the table does not say why"
"$tool" bake "$toy" $options --out alone.fbk > out 2>&1
cmp alone.fbk faces/toy.fbk

echo "the same command submits what is not done, once the job before is over"
cp "$faulty" librig_late.so
before=$(stat -c %Y faces/toy.log)
FB_FAULT=sleeps "$tool" farm characters.txt --out faces --slurm
grep -qx "#SBATCH --array=0-0" faces/farm.sbatch
wait_for "the task does not begin" sh -c "'$tool' farm characters.txt --out faces --status 2> /dev/null | grep late | grep -q running"
if "$tool" farm characters.txt --out faces --slurm > out 2> log; then fail "a job was submitted twice"; fi
grep -q "still in Slurm's queue" log || fail "$(cat log)"

echo "a job that is cancelled goes on"
wait_for "no pose is kept" test -s faces/late.fbk.work/rig.evaluations
scancel "$(cut -d';' -f1 faces/farm.job)"
wait_for "the job does not end" job_is_over
wait_for "the bake does not stop" sh -c "'$tool' farm characters.txt --out faces --status 2> /dev/null | grep late | grep -q stopped"
"$tool" farm characters.txt --out faces --slurm
wait_for "the job does not end" job_is_over
"$tool" farm characters.txt --out faces --status > table || fail "not all are done: $(cat table)"
cat table
[ "$(stat -c %Y faces/toy.log)" = "$before" ] || fail "what was done was baked again"
"$tool" bake "$folder/librig_late.so" $options --out late.fbk > out 2>&1
cmp late.fbk faces/late.fbk
"$tool" farm characters.txt --out faces --slurm > out 2> log || fail "nothing to do is a failure: $(cat log)"

if [ -x "$build/bin/facebaker-mpi" ]; then
  echo "one character on two ranks, started by srun, and by mpirun in a job script"
  export OMP_WAIT_POLICY=PASSIVE OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  srun --ntasks=2 --mpi=pmix --kill-on-bad-exit=1 "$build/bin/facebaker-mpi" bake "$toy" $options --out srun.fbk \
    > out 2> log || fail "srun: $(cat log)"
  cmp alone.fbk srun.fbk
  cat > ranks.sh << END
#!/bin/sh
#SBATCH --ntasks=2
exec mpirun "$build/bin/facebaker-mpi" bake "$toy" $options --out mpirun.fbk
END
  sbatch --wait --output=ranks.log ranks.sh > out || fail "mpirun in a job script: $(cat ranks.log)"
  cmp alone.fbk mpirun.fbk
fi
echo "facebaker farm works with Slurm on this machine"
