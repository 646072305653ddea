#!/bin/sh
# facebaker-mpi over OpenMPI on this machine: the same archive for any number of ranks, a rig's child that is killed, a
# rank that is killed, Ctrl-C, a rank that finds no rig, and how much faster two ranks evaluate than one.
#   tests/mpi/run.sh [BUILD]
# BUILD (build/release) has facebaker, facebaker-mpi and rig_faulty. Installs OpenMPI, from Debian, if it is missing;
# facebaker-mpi is then there after CMake has run once more. Takes 3 minutes, most of which a rig sleeps.
set -eu
cd "$(dirname "$0")/../.."
build=$(realpath "${1:-build/release}")
bin=$build/bin rig=$build/tests/bake/faulty_rig/librig_faulty.so
if ! command -v mpirun > /dev/null || ! command -v mpicc > /dev/null; then
  apt-get install -y --no-install-recommends libopenmpi-dev openmpi-bin
fi
if ! [ -x "$bin/facebaker-mpi" ]; then
  cmake -DFB_MPI=ON "$build"
  cmake --build "$build" --target facebaker facebaker-mpi rig_faulty
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
export OMP_WAIT_POLICY=PASSIVE OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

fail() { echo "FAILED: $1" >&2; exit 1; }
ranks() { n=$1; shift; mpirun -n "$n" --oversubscribe --bind-to none "$bin/facebaker-mpi" "$@"; }
# begin ARGUMENT...: two ranks in the background; `job` is mpirun.
begin() {
  mpirun -n 2 --oversubscribe --bind-to none "$bin/facebaker-mpi" "$@" > out 2> log &
  job=$!
}
bake="--recipe linear --use variant --poses"

# rank_pid MPIRUN RANK: waits for the process of a rank.
rank_pid() {
  for _ in $(seq 100); do
    for pid in $(pgrep -P "$1"); do
      if tr '\0' '\n' < "/proc/$pid/environ" 2> /dev/null | grep -qx "OMPI_COMM_WORLD_RANK=$2"; then
        echo "$pid"
        return
      fi
    done
    sleep 0.1
  done
  fail "there is no rank $2"
}
# wait_for_evaluations ARCHIVE: until some of its bake are kept.
wait_for_evaluations() {
  for _ in $(seq 300); do
    [ "$(stat -c %s "$1.work/rig.evaluations" 2> /dev/null || echo 0)" -gt 20000 ] && return
    sleep 0.1
  done
  fail "no evaluations of $1 are kept"
}

echo "the same archive for any number of ranks"
"$bin/facebaker" bake "$rig" $bake 300 --out alone.fbk > out 2> log
for n in 1 2 4; do
  ranks "$n" bake "$rig" $bake 300 --out "ranks-$n.fbk" > /dev/null 2> log || fail "$n ranks: $(cat log)"
  cmp alone.fbk "ranks-$n.fbk"
done
ranks 2 bake "$rig" $bake 300 --workers 2 --out children.fbk > /dev/null 2> log || fail "children: $(cat log)"
cmp alone.fbk children.fbk

echo "a child that is killed on rank 1 is started again"
export FB_FAULT=sleeps
begin bake "$rig" $bake 300 --isolate --out killed.fbk
wait_for_evaluations killed.fbk
child=$(pgrep -P "$(rank_pid $job 1)" | head -n 1)
[ -n "$child" ] || fail "rank 1 has no child"
kill -9 "$child"
wait $job || fail "after a child was killed: $(cat log)"
cmp alone.fbk killed.fbk

echo "a rank that is killed ends the job, and the same command goes on"
begin bake "$rig" $bake 300 --out dead.fbk
wait_for_evaluations dead.fbk
kill -9 "$(rank_pid $job 1)"
if wait $job; then fail "a dead rank went unnoticed"; fi
[ ! -e dead.fbk ] || fail "there is an archive of a bake that ended early"
ranks 2 bake "$rig" $bake 300 --json --out dead.fbk > dead.json 2> log || fail "going on: $(cat log)"
cmp alone.fbk dead.fbk
ranks 2 bake "$rig" $bake 300 --json --out whole.fbk > whole.json 2> log
calls() { sed -n 's/^ *"rig_calls": \([0-9]*\).*/\1/p' "$1"; }
[ "$(calls dead.json)" -lt "$(calls whole.json)" ] || fail "what was evaluated before is evaluated again"

echo "Ctrl-C stops all ranks, and without MPI the bake goes on"
begin bake "$rig" $bake 300 --out stopped.fbk
wait_for_evaluations stopped.fbk
kill -INT $job
if wait $job; then fail "an interrupted job has succeeded"; fi
"$bin/facebaker" bake "$rig" $bake 300 --json --out stopped.fbk > stopped.json 2> log || fail "going on: $(cat log)"
cmp alone.fbk stopped.fbk
[ "$(calls stopped.json)" -lt "$(calls whole.json)" ] || fail "what was evaluated before is evaluated again"

echo "a rank that finds no rig is named"
mkdir elsewhere
cp "$rig" moved.so
if mpirun -n 2 --oversubscribe --bind-to none sh -c \
    "[ \$OMPI_COMM_WORLD_RANK = 0 ] || cd elsewhere; exec $bin/facebaker-mpi bake ./moved.so $bake 60 --out no.fbk" \
    > out 2> log; then
  fail "a rank without a rig went unnoticed"
fi
grep -q "rank 1 on .*moved.so" log || fail "the rank without a rig is not named: $(cat log)"

echo "evaluation alone, of a rig that sleeps 20 ms a pose: ranks, poses, seconds"
seconds() {
  python3 -c "
import json, sys
stages = json.load(open(sys.argv[1]))['asked_by_stage']
print(sum(s['evaluated'] for s in stages), round(sum(s['seconds'] for s in stages), 2))" "$1"
}
for n in 1 2; do
  ranks "$n" bake "$rig" $bake 2000 --json --out "slow-$n.fbk" > "slow-$n.json" 2> log || fail "$n ranks: $(cat log)"
  echo "$n $(seconds "slow-$n.json")"
done
cmp slow-1.fbk slow-2.fbk
python3 -c "
import sys
one, two = (float(text.split()[1]) for text in sys.argv[1:])
print(f'{one / two:.2f} times as fast')
sys.exit(one / two < 1.9)" "$(seconds slow-1.json)" "$(seconds slow-2.json)" || fail "two ranks are not 1.9 times as fast"
echo "facebaker-mpi works on this machine"
