"""A Slurm of one node on this machine, for tests: started in a folder, ended again.

It needs root and Debian's slurmctld, slurmd, slurm-client and munge, as `.ci/run` installs them where it can.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PROGRAMS = ("slurmctld", "slurmd", "sbatch", "scontrol", "squeue", "munged")
CORES = 2

PATIENCE = 60.0
"""Seconds for the node to be ready."""

CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=cred_expire=5,socket={folder}/munge.socket
SlurmctldPort={port}
SlurmdPort={node_port}
SlurmdParameters=config_overrides
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
MpiDefault=none
KillWait=5
MinJobAge=3600
JobRequeue=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=8000 State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE DefMemPerCPU=500 State=UP
"""


def why_not() -> str:
    """Return what keeps a Slurm from being started here; empty for nothing."""
    absent = [name for name in PROGRAMS if shutil.which(name, path=_path()) is None]
    if absent:
        return f"no {', '.join(absent)}: apt-get install --no-install-recommends slurmctld slurmd slurm-client munge"
    return "" if os.geteuid() == 0 else "a Slurm of one's own needs root"


@contextmanager
def running_slurm(folder: Path) -> Iterator[dict[str, str]]:
    """A ready Slurm with its files in `folder`; the environment in which its commands find it."""
    host = socket.gethostname().partition(".")[0]
    port, node_port = _free_ports()
    for name in ("state", "spool"):
        (folder / name).mkdir()
    configuration = folder / "slurm.conf"
    configuration.write_text(
        CONFIGURATION.format(host=host, folder=folder, port=port, node_port=node_port, cores=CORES)
    )
    environment = {**os.environ, "SLURM_CONF": str(configuration), "PATH": _path()}
    processes: list[subprocess.Popen[bytes]] = []
    with (folder / "daemons.log").open("wb") as log:

        def start(*line: str) -> None:
            processes.append(subprocess.Popen(line, env=environment, stdout=log, stderr=log, start_new_session=True))

        try:
            _prepare_munge(folder)
            munged = shutil.which("munged", path=_path()) or "munged"
            as_munge = ("setpriv", "--reuid=munge", "--regid=munge", "--clear-groups", munged)
            start(*as_munge, "--foreground", "--force", f"--socket={folder}/munge.socket", *_munge_files(folder))
            start("slurmctld", "-D", "-f", str(configuration))
            start("slurmd", "-D", "-f", str(configuration), "-N", host)
            _wait_until_idle(environment, processes, folder)
            yield environment
        finally:
            subprocess.run(["scancel", "--user=root"], env=environment, check=False, capture_output=True)
            for process in reversed(processes):
                process.send_signal(signal.SIGTERM)
            for process in processes:
                try:
                    process.wait(timeout=2)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


def _munge_files(folder: Path) -> list[str]:
    own = folder / "munge"
    return [f"--key-file={own}/key", f"--pid-file={own}/pid", f"--log-file={own}/log", f"--seed-file={own}/seed"]


def _prepare_munge(folder: Path) -> None:
    own = folder / "munge"
    own.mkdir(mode=0o755)
    (own / "key").write_bytes(os.urandom(1024))
    (own / "key").chmod(0o600)
    for path in (own, own / "key"):
        shutil.chown(path, "munge", "munge")
    folder.chmod(0o777)  # munged makes its socket there


def _wait_until_idle(environment: dict[str, str], processes: list[subprocess.Popen[bytes]], folder: Path) -> None:
    end = time.monotonic() + PATIENCE
    while True:
        line = ["sinfo", "--noheader", "--format=%t"]
        found = subprocess.run(line, env=environment, capture_output=True, text=True, check=False)
        if found.stdout.strip() == "idle":
            return
        dead = [process.args for process in processes if process.poll() is not None]
        if dead or time.monotonic() > end:
            logs = "\n".join(path.read_text(errors="replace")[-2000:] for path in folder.glob("*.log"))
            raise RuntimeError(f"Slurm does not start: {dead}: {found.stdout} {found.stderr}\n{logs}")
        time.sleep(0.2)


def _free_ports() -> tuple[int, int]:
    sockets = [socket.socket() for _ in range(2)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports[0], ports[1]


def _path() -> str:
    return os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
