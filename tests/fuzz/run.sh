#!/bin/sh
# run.sh SECONDS [NAME...]: fuzzes each target (all without names) for SECONDS with libFuzzer under AddressSanitizer and
# UndefinedBehaviorSanitizer (clang), one after the other at the lowest priority. What each finds stays in
# build/fuzz/found/NAME and is where the next run goes on from. Prints executions, coverage and findings; fails if
# anything was found, which then lies in build/fuzz/crashes/NAME.
# run.sh keep [NAME...]: adds to tests/fuzz/corpus/NAME the inputs of at most 1,024 bytes that reach code which it does
# not reach.
set -eu
cd "$(dirname "$0")/../.."
what=${1:?give seconds, or keep}
shift
[ $# -gt 0 ] || set -- archive dataset npy gltf plugin rig_messages work rights signatures markers texture capture http
build=build/fuzz
sanitizers=address,undefined,fuzzer-no-link
CC=clang CXX=clang++ cmake -S . -B $build -G Ninja -DFB_FUZZ=ON -DFB_SANITIZE=$sanitizers \
  -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1 -DNDEBUG" >/dev/null
for name; do targets="${targets-} fuzz_$name"; done
cmake --build $build --target $targets
export OMP_NUM_THREADS=1 ASAN_OPTIONS=quarantine_size_mb=16:allocator_release_to_os_interval_ms=2000
failed=0
for name; do
  program=$build/bin/fuzz_$name
  corpus=tests/fuzz/corpus/$name
  found=$build/found/$name
  mkdir -p "$found" "$build/crashes/$name"
  if [ "$what" = keep ]; then
    "$program" -merge=1 -use_counters=0 -max_len=1024 -rss_limit_mb=4096 "$corpus" "$found" 2>&1 | tail -1
    continue
  fi
  seeds=tests/golden
  [ "$name" = archive ] || seeds=
  words=
  [ ! -f tests/fuzz/"$name".dict ] || words=-dict=tests/fuzz/$name.dict
  echo "fuzz_$name:"
  nice -n 19 "$program" -max_total_time="$what" -timeout=20 -rss_limit_mb=4096 -max_len=65536 -reload=0 \
    $words -print_final_stats=1 -artifact_prefix=$build/crashes/"$name"/ "$found" "$corpus" $seeds >$build/"$name".log 2>&1 || failed=1
  grep -E "^#.*DONE|number_of_executed_units|slowest_unit|peak_rss|SUMMARY|artifact_prefix" $build/"$name".log || true
done
exit $failed
