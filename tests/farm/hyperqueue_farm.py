"""`niji farm` on a real HyperQueue: a server and a worker in this process.

hyperqueue_farm.py NIJI FOLDER    as tests/farm/slurm.sh
"""
import os
import subprocess
import sys
from pathlib import Path

os.environ["TQDM_DISABLE"] = "1"  # before it is imported

from hyperqueue import LocalCluster  # noqa: E402
from hyperqueue.cluster import WorkerConfig  # noqa: E402
from hyperqueue.job import SubmittedJob  # noqa: E402

niji, work = os.path.abspath(sys.argv[1]), Path(sys.argv[2]).resolve()
out = work / "h q {{x}}'\""  # a name that has to be quoted


def run(*command):
    return subprocess.run([str(it) for it in command], check=False, capture_output=True, text=True)


def same(one, other):
    pictures = sorted((work / one).glob("image.*"))
    assert len(pictures) in (3, 36), pictures
    for picture in pictures:
        assert picture.read_bytes() == (other / picture.name).read_bytes(), picture.name


with LocalCluster(worker_config=WorkerConfig(cores=2)) as cluster:
    client = cluster.client()

    def job(program, *arguments):
        """Whether a job succeeds with another program in its tasks; it ends in any case."""
        os.environ |= {"HQ_SERVER_DIR": str(cluster.cluster.server_dir), "NIJI": str(program), "NIJI_MEMORY": "any"}
        told = run(niji, "farm", *arguments, "--engine", "hyperqueue", "--threads", 1, "--submit")
        assert told.returncode == 0, told.stderr
        number = int(told.stdout.split()[-1])
        return client.wait_for_jobs([SubmittedJob(job=None, id=number)], raise_on_error=False)

    print("hyperqueue: frames, of which some fail")
    fails = work / "fails"
    fails.write_text(f'#!/bin/bash\ncase "$*" in *"--frames 7-9 "*) exit 1 ;; esac\nexec "{niji}" "$@"\n')
    fails.chmod(0o755)
    assert not job(fails, work / "sequence.toml", "-o", out, "--frames", "1-12", "--chunk", 3)
    status = run(niji, "farm", "status", out)
    assert (status.returncode, status.stdout) == (6, "7-9\n"), status
    assert job(niji, work / "sequence.toml", "-o", out, "--frames", "7-9")
    same("one", out)

    print("hyperqueue: a picture in tiles, and frames in tiles")
    assert job(niji, work / "picture.toml", "-o", work / "h-tiles", "--tiles", 8)
    same("one-picture", work / "h-tiles")
    assert job(niji, work / "sequence.toml", "-o", work / "h-all", "--frames", "1-12", "--tiles", 4, "--chunk", 2)
    same("one", work / "h-all")
print("hyperqueue: done")
