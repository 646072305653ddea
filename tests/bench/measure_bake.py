"""Bakes the dense rig and keeps what that took: measure_bake.py BUILD KEEP DIVISIONS,CONTROLS,POSES,RECIPE,USE

Writes KEEP/<row>.fbk and KEEP/<row>.json, unless they are there: processor seconds, peak memory, the most disk that the
work folder took, and the bake's own figures. Used by bench_scale.sh."""
import json
import os
import resource
import shutil
import subprocess
import sys
import threading


def folder_bytes(path):
    total = 0
    for folder, _, files in os.walk(path):
        for name in files:
            try:
                total += os.stat(os.path.join(folder, name)).st_blocks * 512
            except FileNotFoundError:  # a temporary file that was renamed
                pass
    return total


def main():
    build, keep, row = sys.argv[1:]
    divisions, controls, poses, recipe, use = row.split(",")
    face, figures, work = (os.path.join(keep, row + ending) for ending in (".fbk", ".json", ".work"))
    if os.path.exists(figures):
        return
    shutil.rmtree(work, ignore_errors=True)
    environment = dict(os.environ, FB_RIG_DIVISIONS=divisions, FB_RIG_CONTROLS=controls)
    command = [os.path.join(build, "bin", "facebaker"), "bake", os.path.join(build, "lib", "rigs", "librig_dense.so"), "--out", face,
               "--poses", poses, "--recipe", recipe, "--use", use, "--work", work, "--json"]
    print(row, file=sys.stderr, flush=True)
    most, done = [0], threading.Event()

    def watch():
        while not done.wait(1):
            most[0] = max(most[0], folder_bytes(work))

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        out = subprocess.run(command, env=environment, check=True, text=True, stdout=subprocess.PIPE).stdout
    finally:
        done.set()
        watcher.join()
        shutil.rmtree(work, ignore_errors=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = {"cpu": used.ru_utime + used.ru_stime, "peak": used.ru_maxrss * 1024, "disk": most[0], "bake": json.loads(out)}
    with open(figures + ".new", "w", encoding="utf-8") as file:
        json.dump(result, file, indent=1)
    os.rename(figures + ".new", figures)


if __name__ == "__main__":
    main()
