//! The binary as its users meet it: what it prints, what it writes, and how it exits.

mod check;
mod print;
mod run;

use std::path::{Path, PathBuf};

use assert_cmd::Command;

const DONE: i32 = 0;
const BAD_INPUT: i32 = 2;

/// `feeler` in a folder of its own.
struct Bench {
    folder: tempfile::TempDir,
}

/// What a command said.
struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    fn feeler(&self, arguments: &[&str]) -> Said {
        let mut command = Command::new(env!("CARGO_BIN_EXE_feeler"));
        let output = command.current_dir(self.folder.path()).args(arguments).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap().replace("feeler.exe", "feeler");
        Said { code: output.status.code().unwrap(), out: text(&output.stdout), err: text(&output.stderr) }
    }
}

/// A tool of 2 kg pressed softly against a wall: no noise, quick to run, settles.
const PRESS: &str = include_str!("../data/press.toml");

fn exists(path: impl AsRef<Path>) -> bool {
    path.as_ref().exists()
}
