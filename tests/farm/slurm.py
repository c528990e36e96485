# SPDX-License-Identifier: Apache-2.0
"""A Slurm of this machine's own: munge, slurmctld and slurmd, no systemd, no root's files.

Everything lies in one temporary folder; ports are free ones.
"""

import getpass
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import time

CONF = """
ClusterName=rackfocus
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge.socket
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,bf_interval=1,sched_min_interval=0
ReturnToService=2
SlurmdTimeout=6
KillWait=1
MinJobAge=300
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(n):
    sockets = [socket.socket() for _ in range(n)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def program(name):
    return shutil.which(name) or shutil.which(name, path="/usr/sbin:/sbin")


def is_there():
    return all(program(n) for n in ("munged", "slurmctld", "slurmd", "sbatch"))


class Slurm:
    def __init__(self, cpus=2):
        # Names of sockets are short.
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="rf-slurm-", dir="/tmp"))
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        conf = self.folder / "slurm.conf"
        conf.write_text(
            CONF.format(
                folder=self.folder,
                host=socket.gethostname().split(".")[0],
                user=getpass.getuser(),
                ports=free_ports(2),
                cpus=cpus,
            )
        )
        self.env = {**os.environ, "SLURM_CONF": str(conf)}
        self.daemons = {}
        self.begins_later = {}  # jobs that wait for their time: when that was seen
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        try:
            self.start(
                "munged",
                "--foreground",
                "--force",
                f"--key-file={key}",
                f"--socket={self.folder}/munge.socket",
                f"--pid-file={self.folder}/munge.pid",
                f"--log-file={self.folder}/munge.log",
                f"--seed-file={self.folder}/munge.seed",
            )
            self.wait(lambda: (self.folder / "munge.socket").exists(), "munged")
            self.start("slurmctld", "-D")
            self.start_node()
        except BaseException:
            self.stop()
            raise

    def start(self, name, *arguments):
        log = open(self.folder / f"{name}.out", "ab")
        self.daemons[name] = subprocess.Popen(
            [program(name), *arguments],
            env=self.env,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )
        log.close()

    def wait(self, is_so, what, seconds=60):
        end = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > end:
                logs = [
                    p.read_text(errors="replace")[-2000:]
                    for p in sorted(self.folder.glob("*.log"))
                ]
                raise TimeoutError("\n".join([what, *logs]))
            time.sleep(0.1)

    def wake(self):
        """What an operator does after losses: gives back a node that Slurm has set
        aside, and jobs that it holds because their start failed."""
        if "drain" in self.ask("sinfo", "-h", "-o", "%T") or "down" in self.ask(
            "sinfo", "-h", "-o", "%T"
        ):
            self.ask("scontrol", "update", "nodename=ALL", "state=resume")
        for line in self.ask("squeue", "-h", "-r", "-o", "%i %r").splitlines():
            job = line.split()[0]
            if "BeginTime" in line:
                self.wake_early(job)
            elif "held" in line.lower():
                self.ask("scontrol", "release", job)

    def wake_early(self, job):
        """Slurm lets what it starts again wait for two minutes; it needs that second in
        which it took the job back: in the same one the new start is refused ("Job
        credential revoked"), and the task is over.
        """
        seen = self.begins_later.setdefault(job, time.monotonic())
        if time.monotonic() > seen + 2:
            self.ask("scontrol", "update", f"jobid={job}", "starttime=now")
            del self.begins_later[job]

    def start_node(self):
        self.start("slurmd", "-D")
        self.wait(
            lambda: self.wake()
            or self.ask("sinfo", "-h", "-o", "%t") in ("idle", "mix", "alloc"),
            "slurmd",
        )

    def stop_node(self):
        """As if the machine were gone: slurmd and what it runs."""
        self.kill("slurmd")
        for task in self.tasks():
            self.ask("scancel", "--signal=KILL", task)

    def kill(self, name):
        daemon = self.daemons.pop(name, None)
        if daemon:
            daemon.kill()
            daemon.wait()

    def ask(self, *command):
        done = subprocess.run(command, env=self.env, capture_output=True, text=True)
        return done.stdout.strip()

    def tasks(self, states="RUNNING"):
        return self.ask("squeue", "-h", "-r", "-o", "%i", "-t", states).split()

    def wait_for_jobs(self, seconds=120):
        """None left; a controller that does not answer has not said so."""

        def is_empty():
            self.wake()
            done = subprocess.run(
                ["squeue", "-h", "-r"], env=self.env, capture_output=True, text=True
            )
            return done.returncode == 0 and not done.stdout.strip()

        self.wait(is_empty, "jobs", seconds)

    def stop(self):
        self.ask("scancel", "--user", getpass.getuser())
        for name in ("slurmd", "slurmctld", "munged"):
            self.kill(name)
        shutil.rmtree(self.folder, ignore_errors=True)
