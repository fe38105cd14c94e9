//! Folders in which `feeler` runs.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

pub(crate) const DONE: i32 = 0;
pub(crate) const CHECK_FAILED: i32 = 1;
pub(crate) const BAD_INPUT: i32 = 2;

/// `feeler` in its own folder.
pub(crate) struct Bench {
    folder: tempfile::TempDir,
}

/// Exit code and output of a command.
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn feeler(&self, arguments: &[&str]) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_feeler"));
        let output = command.current_dir(self.folder.path()).args(arguments).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap().replace("feeler.exe", "feeler");
        Said { code: output.status.code().unwrap(), out: text(&output.stdout), err: text(&output.stderr) }
    }
}

/// A tool of 2 kg pressed softly against a wall: no noise, quick to run, settles.
pub(crate) const PRESS: &str = include_str!("../data/press.toml");

pub(crate) fn exists(path: impl AsRef<Path>) -> bool {
    path.as_ref().exists()
}

/// `feeler` in the folder of the shipped scenarios.
pub(crate) fn shipped() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_feeler"));
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios"));
    command
}

/// Standard output of `feeler` in the folder of the shipped scenarios.
pub(crate) fn printed(arguments: &[&str]) -> String {
    let output = shipped().args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Error output of a request that fails.
pub(crate) fn refused(arguments: &[&str]) -> String {
    let output = shipped().args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// Output of `feeler` with `--json`.
pub(crate) fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(arguments)).unwrap()
}
