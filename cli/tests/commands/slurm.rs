//! Runs the sample job script under a real Slurm, which the test starts on this host.

use std::fmt::Write as _;
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;

use super::sweep::{JOB_SCRIPT, SWEEP, project, run};

/// Longest wait for the node to register, and for a job of three short tasks to end.
const PATIENCE: Duration = Duration::from_secs(90);
/// Folders of daemons, in addition to the search path.
const FOLDERS: [&str; 3] = ["/usr/sbin", "/usr/local/sbin", "/sbin"];
/// Programs that the test needs.
const PROGRAMS: [&str; 5] = ["munged", "slurmctld", "slurmd", "sinfo", "sbatch"];

/// A Slurm of one host with its own folder, ports, keys and configuration. It does not interfere with a Slurm
/// that manages this host, and needs no special rights.
struct Slurm {
    folder: tempfile::TempDir,
    daemons: Vec<(&'static str, Child)>,
}

impl Slurm {
    /// Starts the daemons, or reports why they do not run here.
    fn start() -> Result<Self, String> {
        let missing: Vec<&str> = PROGRAMS.into_iter().filter(|name| program(name).is_none()).collect();
        if !missing.is_empty() {
            return Err(format!(
                "not installed: {} (on Debian `apt-get install slurm-wlm munge`)",
                missing.join(", ")
            ));
        }
        let said = |what: &'static str| move |error: std::io::Error| format!("{what}: {error}");
        let folder =
            tempfile::Builder::new().prefix("feeler-slurm-").tempdir().map_err(said("a folder for it"))?;
        let mut slurm = Self { folder, daemons: Vec::new() };
        slurm.configure().map_err(said("its configuration"))?;
        let munge = ["--foreground".into()].into_iter().chain(
            [
                ("key-file", "munge.key"),
                ("socket", "munge.socket"),
                ("pid-file", "munge.pid"),
                ("seed-file", "munge.seed"),
            ]
            .map(|(option, name)| format!("--{option}={}", slurm.at(name).display())),
        );
        slurm.daemon("munged", munge.collect())?;
        for name in ["slurmctld", "slurmd"] {
            slurm.daemon(name, vec!["-D".into()])?;
        }
        slurm.wait_until_idle()?;
        Ok(slurm)
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn configure(&self) -> std::io::Result<()> {
        // Munge requires a socket that all can access, and a key that nobody else can read.
        fs::set_permissions(self.folder.path(), fs::Permissions::from_mode(0o755))?;
        let mut key = [0; 1024];
        fs::File::open("/dev/urandom")?.read_exact(&mut key)?;
        fs::write(self.at("munge.key"), key)?;
        fs::set_permissions(self.at("munge.key"), fs::Permissions::from_mode(0o400))?;
        for name in ["state", "spool", "cgroup"] {
            fs::create_dir(self.at(name))?;
        }
        // An unused mount point: the host's control groups stay unchanged.
        fs::write(
            self.at("cgroup.conf"),
            format!(
                "CgroupPlugin=cgroup/v1\nCgroupAutomount=no\nCgroupMountpoint={}\n",
                self.at("cgroup").display()
            ),
        )?;
        let free = [TcpListener::bind("127.0.0.1:0")?, TcpListener::bind("127.0.0.1:0")?];
        let [controller, node] = [free[0].local_addr()?.port(), free[1].local_addr()?.port()];
        let (host, user) = (printed("hostname", &["-s"])?, printed("id", &["-un"])?);
        let place = self.folder.path().display();
        fs::write(
            self.at("slurm.conf"),
            format!(
                "ClusterName=feeler\nSlurmctldHost={host}(127.0.0.1)\n\
                 SlurmctldPort={controller}\nSlurmdPort={node}\n\
                 SlurmUser={user}\nSlurmdUser={user}\n\
                 AuthType=auth/munge\nAuthInfo=socket={place}/munge.socket\nCredType=cred/munge\n\
                 StateSaveLocation={place}/state\nSlurmdSpoolDir={place}/spool\n\
                 SlurmctldPidFile={place}/slurmctld.pid\nSlurmdPidFile={place}/slurmd.pid\n\
                 ProctrackType=proctrack/pgid\nTaskPlugin=task/none\n\
                 JobAcctGatherType=jobacct_gather/none\nSwitchType=switch/none\n\
                 MpiDefault=none\nReturnToService=2\n\
                 SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\n\
                 SlurmdParameters=config_overrides\n\
                 NodeName={host} NodeAddr=127.0.0.1 CPUs=3 State=UNKNOWN\n\
                 PartitionName=all Nodes={host} Default=YES State=UP\n"
            ),
        )
    }

    fn daemon(&mut self, name: &'static str, arguments: Vec<String>) -> Result<(), String> {
        let said =
            fs::File::create(self.at(&format!("{name}.out"))).map_err(|error| format!("{name}: {error}"))?;
        let mut command = self.command(name);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(said);
        let child = command.spawn().map_err(|error| format!("{name}: {error}"))?;
        self.daemons.push((name, child));
        Ok(())
    }

    /// A program that connects only to this Slurm.
    fn command(&self, name: &str) -> Command {
        let mut command = Command::new(program(name).unwrap_or_else(|| name.into()));
        command.env("SLURM_CONF", self.at("slurm.conf")).current_dir(self.folder.path());
        command
    }

    fn wait_until_idle(&mut self) -> Result<(), String> {
        let started = Instant::now();
        loop {
            for (name, child) in &mut self.daemons {
                if let Ok(Some(status)) = child.try_wait() {
                    let last = self.folder.path().join(format!("{name}.out"));
                    return Err(format!("{name} ended with {status}: {}", tail(&last)));
                }
            }
            let nodes = self.command("sinfo").args(["--noheader", "--format=%t"]).output();
            let states = nodes.map_or_else(|error| error.to_string(), |output| text(&output));
            if states.trim() == "idle" {
                return Ok(());
            }
            if started.elapsed() > PATIENCE {
                let last: Vec<String> =
                    self.daemons.iter().map(|(name, _)| tail(&self.at(&format!("{name}.out")))).collect();
                return Err(format!(
                    "its node is `{}` after {} s: {}",
                    states.trim(),
                    PATIENCE.as_secs(),
                    last.join("; ")
                ));
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Submits a job and waits for its end.
    fn submit(&self, arguments: &[&str], folder: &Path) -> Output {
        let mut child = (self
            .command("sbatch")
            .arg("--wait")
            .args(arguments)
            .env("FEELER", cargo_bin("feeler"))
            .current_dir(folder))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
        let started = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if started.elapsed() > PATIENCE {
                child.kill().unwrap();
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        child.wait_with_output().unwrap()
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        for (_, child) in self.daemons.iter_mut().rev() {
            // The process may have ended already.
            let _ = child.kill().and_then(|()| child.wait());
        }
    }
}

fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(FOLDERS.map(PathBuf::from));
    folders.map(|folder| folder.join(name)).find(|file| file.is_file())
}

fn printed(name: &str, arguments: &[&str]) -> std::io::Result<String> {
    Command::new(name)
        .args(arguments)
        .output()
        .map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat()
}

/// The last lines of a file, joined to one.
fn tail(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(3)..].join(" | ")
}

#[test]
fn prop_an_array_job_of_slurm_gives_the_same_bytes() {
    let slurm = match Slurm::start() {
        Ok(slurm) => slurm,
        Err(why) => {
            // A passing test hides the output of `eprintln!`.
            let _ = writeln!(
                std::io::stderr(),
                "skipped: no Slurm can be started on this host, {why}; the job script was not run"
            );
            return;
        }
    };
    let (folder, sweep) = project();
    // Three chunks, one for each task.
    fs::write(&sweep, SWEEP.replace("points = 20", "points = 2")).unwrap();
    let [one, array] = ["one", "array"].map(|name| folder.path().join(name));
    run(&["sweep", sweep.to_str().unwrap(), "--out", one.to_str().unwrap()]);
    let ended = slurm.submit(
        &["--array=1-3", JOB_SCRIPT, sweep.to_str().unwrap(), array.to_str().unwrap()],
        folder.path(),
    );
    let tasks = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    let said = tasks.filter(|path| path.extension().is_some_and(|end| end == "out")).fold(
        String::new(),
        |mut said, path| {
            let _ = writeln!(said, "{}: {}", path.display(), tail(&path));
            said
        },
    );
    assert!(ended.status.success(), "{}{said}", text(&ended));
    assert_eq!(fs::read_dir(array.join("chunks")).unwrap().count(), 3, "{said}");
    run(&["merge", array.to_str().unwrap()]);
    assert!(fs::read(one.join("sweep.parquet")).unwrap() == fs::read(array.join("sweep.parquet")).unwrap());
}
