//! A reader who follows a page: runs its commands, writes its files, compares its output.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::page::{Block, blocks, has_ending, root, text_of};

/// Commands of blocks that no test runs, each with its reason.
pub(crate) const NOT_RUN: [(&str, &str); 6] = [
    ("cargo test --workspace", "it runs this test"),
    ("cargo bench -p feeler-benches", "hours on an idle machine"),
    ("benches/peers/run", "hours, and installs other simulators"),
    ("cargo run --release -p feeler-benches --example limits", "hours on an idle machine"),
    ("benches/instructions", "hours under valgrind"),
    ("benches/cache", "hours under valgrind"),
];

/// `println!` would not be shown, because a passing test captures its output.
fn say_skipped(what: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {what}");
}

/// Pages with blocks of plain text, and the content of these blocks.
const TEXT: [(&str, &str); 3] = [
    ("docs/arms.md", "formulas"),
    ("docs/commands.md", "help pages, which a test of the arguments compares"),
    ("docs/tutorials/servo-joint.md", "an answer that depends on the computer"),
];

/// Files to which the snippets of a page are added; on any other page, the file that the page wrote last.
const BASES: [(&str, &str); 3] = [
    ("docs/effects.md", "scenarios/effects/ideal.toml"),
    ("docs/servos.md", "servo.toml"),
    ("docs/surfaces.md", "scenarios/surface/waves.toml"),
];

/// Pages whose long commands run, and not only their arguments are checked: `1` for all, or a part of a path.
pub(crate) fn long_pages() -> Option<String> {
    std::env::var("FEELER_BOOK_LONG").ok()
}

fn is_long() -> bool {
    long_pages().is_some()
}

fn has_network() -> bool {
    let found = ("github.com", 443).to_socket_addrs().ok().and_then(|mut places| places.next());
    found.is_some_and(|place| TcpStream::connect_timeout(&place, Duration::from_secs(5)).is_ok())
}

/// A folder in which the commands of one page run one after another. It holds the files of the project that
/// they need.
pub(crate) struct Reader {
    around: tempfile::TempDir,
    page: String,
    /// By the commands of the block before, if they ran.
    printed: Option<String>,
    /// Files that the page has written.
    written: Vec<String>,
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

impl Reader {
    pub(crate) fn new(page: &str) -> Self {
        let around = tempfile::tempdir().unwrap();
        let reader = Self { around, page: page.to_owned(), printed: None, written: Vec::new() };
        copy(&root().join("scenarios"), &reader.folder().join("scenarios"));
        let project = root().canonicalize().unwrap();
        symlink(project.join("logs"), reader.folder().join("logs")).unwrap();
        // Data too large for the project are in a folder beside it.
        let beside = project.join("../shared");
        if beside.exists() {
            symlink(beside, reader.around.path().join("shared")).unwrap();
        }
        reader
    }

    pub(crate) fn folder(&self) -> PathBuf {
        self.around.path().join("feeler")
    }

    fn command(&self, line: &str) -> Command {
        let binary = Path::new(env!("CARGO_BIN_EXE_feeler")).parent().unwrap();
        let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap_or_default());
        let mut command = Command::new("sh");
        command.args(["-c", line]).env("PATH", path).env("COLUMNS", "100").current_dir(self.folder());
        command
    }

    fn shell(&self, line: &str) -> Result<String, String> {
        let output = self.command(line).output().map_err(|error| error.to_string())?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let said = format!("{}{}", text(&output.stdout), text(&output.stderr));
        if output.status.success() { Ok(said) } else { Err(format!("{}\n{said}", output.status)) }
    }

    /// Checks the arguments of a command without running it: with valid arguments `--help` prints the help.
    pub(crate) fn understands(&self, line: &str) -> Result<(), String> {
        let command = line.split(" | ").next().and_then(|line| line.split(" > ").next()).unwrap_or(line);
        self.shell(&format!("{command} --help")).map(|_| ()).map_err(|said| format!("`{line}`: {said}"))
    }

    /// Starts the server of a command, asks for its page, and ends it.
    fn live(&self, line: &str) -> Result<String, String> {
        let mut command = self.command(&format!("exec {line}"));
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        let page = first_page(&mut child);
        let _ = child.kill();
        let _ = child.wait();
        page
    }

    /// Runs in the project's folder, and only with the long commands.
    fn cargo(&self, line: &str) -> Result<Option<String>, String> {
        if !is_long() {
            return Ok(None);
        }
        let project = root().canonicalize().map_err(|error| error.to_string())?;
        let installed = self.folder().join("installed");
        let root = installed.display();
        self.shell(&format!("cd '{}' && CARGO_INSTALL_ROOT='{root}' {line}", project.display())).map(Some)
    }

    /// Fetches data, unless they are there already.
    fn fetch(&self, line: &str, runs: bool) -> Result<Option<String>, String> {
        let is_there = self.around.path().join("shared").is_symlink();
        if runs && !is_there { self.shell(line).map(Some) } else { Ok(None) }
    }

    /// Runs only with the long commands; the script must exist in any case.
    fn script(&self, line: &str) -> Result<Option<String>, String> {
        let file = line.split(' ').find(|word| has_ending(word, "py")).ok_or("no script is named")?;
        if !self.folder().join(file).exists() {
            return Err(format!("there is no {file}"));
        }
        if is_long() { self.shell(line).map(Some) } else { Ok(None) }
    }

    fn console(&mut self, block: &Block) -> Result<(), String> {
        self.printed = None;
        let mut printed = Some(String::new());
        let mut runs = true;
        for line in block.text.replace("\\\n", " ").lines().map(str::trim).filter(|line| !line.is_empty()) {
            if let Some(needed) = line.strip_prefix("# needs: ") {
                let is_there =
                    if needed == "network" { has_network() } else { self.folder().join(needed).exists() };
                runs &= is_there;
                if !is_there {
                    say_skipped(&format!("{}:{}: no {needed}", self.page, block.line));
                }
                continue;
            }
            if line.starts_with("# long: ") {
                runs &= is_long();
                continue;
            }
            let line = line.replace("cargo run --release -- ", "feeler ");
            let line = line.replace("/usr/bin/time -v target/release/feeler ", "feeler ");
            let command = line.split(" # ").next().unwrap_or(&line).trim();
            let said = match command.split(' ').next() {
                _ if NOT_RUN.iter().any(|(known, _)| *known == command) => Ok(None),
                Some("feeler") if !runs => self.understands(command).map(|()| None),
                Some("feeler") if command.starts_with("feeler live ") => self.live(command).map(Some),
                Some("feeler") => self.shell(command).map(Some),
                Some("cargo" | "FEELER_BENCH_QUICK=1") => self.cargo(command),
                Some("python3") => self.script(command),
                Some("git" | "mkdir" | "cp" | "for") => self.fetch(command, runs),
                _ => Err("no test runs it".to_owned()),
            };
            let said = said.map_err(|said| format!("`{command}`: {said}"))?;
            printed = printed.zip(said).map(|(before, said)| before + &said);
        }
        self.printed = printed;
        Ok(())
    }

    fn output(&self, block: &Block) -> Result<(), String> {
        let Some(printed) = &self.printed else { return Ok(()) };
        let plain = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = printed.lines().map(plain).collect();
        for wanted in block.text.lines().map(plain).filter(|line| !line.is_empty()) {
            let parts: Vec<&str> = wanted.split("...").map(str::trim).collect();
            let holds = |line: &String| {
                let mut rest = line.as_str();
                parts.iter().all(|part| rest.find(part).map(|at| rest = &rest[at + part.len()..]).is_some())
            };
            if !lines.iter().any(holds) {
                return Err(format!("not printed: {wanted}\nprinted:\n{printed}"));
            }
        }
        Ok(())
    }

    fn python(&self, block: &Block) -> Result<(), String> {
        if self.shell("python3 -c 'import pyarrow'").is_err() {
            say_skipped(&format!("{}:{}: no Python with pyarrow here", self.page, block.line));
            return Ok(());
        }
        std::fs::write(self.folder().join("block.py"), &block.text).map_err(|error| error.to_string())?;
        self.shell("python3 block.py").map(|_| ())
    }

    /// A block that begins with the name of a file is that file. Any other block is added to an existing
    /// file.
    fn toml(&mut self, block: &Block) -> Result<(), String> {
        block.text.parse::<toml::Table>().map_err(|error| error.to_string())?;
        let first = block.text.lines().next().unwrap_or_default();
        let named = first.strip_prefix("# ").filter(|name| has_ending(name, "toml") && !name.contains(' '));
        let Some(name) = named else { return self.snippet(block) };
        let path = self.folder().join(name);
        let shipped = std::fs::read(&path).ok().filter(|_| name.starts_with("scenarios/"));
        std::fs::write(&path, &block.text).map_err(|error| error.to_string())?;
        let checked = self.shell(&format!("feeler check {name}"));
        match shipped {
            Some(bytes) => std::fs::write(&path, bytes).map_err(|error| error.to_string())?,
            None => self.written.push(name.to_owned()),
        }
        checked.map(|_| ())
    }

    fn snippet(&self, block: &Block) -> Result<(), String> {
        let known = BASES.iter().find(|(page, _)| *page == self.page).map(|(_, base)| *base);
        let base = known.or(self.written.last().map(String::as_str)).ok_or("no file on which it lies")?;
        let path = self.folder().join(base);
        let file = path.file_name().and_then(std::ffi::OsStr::to_str).ok_or("no name of a file")?;
        let snippet = path.with_file_name("snippet.toml");
        std::fs::write(&snippet, format!("machine = \"{file}\"\n{}", block.text))
            .map_err(|error| error.to_string())?;
        self.shell(&format!("feeler check {}", snippet.display()))
            .map(|_| ())
            .map_err(|why| format!("on {base}: {why}"))
    }

    pub(crate) fn block(&mut self, block: &Block) -> Result<(), String> {
        match block.language.as_str() {
            "console" => self.console(block),
            "output" => self.output(block),
            "toml" => self.toml(block),
            "json" => serde_json::from_str::<serde_json::Value>(&block.text)
                .map(|_| ())
                .map_err(|error| error.to_string()),
            "python" => self.python(block),
            "text" if TEXT.iter().any(|(page, _)| *page == self.page) => {
                let command = block.text.lines().find(|line| line.starts_with("feeler "));
                command.map_or(Ok(()), |line| Err(format!("`{line}` is a command: make the block `console`")))
            }
            "" if self.page == "ARCHITECTURE.md" => Ok(()),
            other => Err(format!("a block of kind `{other}`, which no test reads")),
        }
    }

    pub(crate) fn read(mut self) -> Vec<String> {
        let text = text_of(&self.page);
        let mut failed = Vec::new();
        for block in blocks(&text) {
            if let Err(why) = self.block(&block) {
                failed.push(format!("{}:{}: {why}", self.page, block.line));
            }
        }
        failed
    }
}

/// The address that a server prints, once it has delivered its page.
fn first_page(child: &mut Child) -> Result<String, String> {
    let text = |error: std::io::Error| error.to_string();
    let mut address = String::new();
    let printed = child.stdout.take().ok_or("no output")?;
    BufReader::new(printed).read_line(&mut address).map_err(text)?;
    let place = address.trim().strip_prefix("http://").and_then(|rest| rest.split_once('/'));
    let (host, path) = place.ok_or_else(|| format!("no address: {address}"))?;
    let mut stream = TcpStream::connect(host).map_err(text)?;
    write!(stream, "GET /{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").map_err(text)?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).map_err(text)?;
    let status = answer.lines().next().unwrap_or_default().to_owned();
    if status.contains(" 200 ") { Ok(address) } else { Err(status) }
}
