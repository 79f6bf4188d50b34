//! The `skyfront` program as a user runs it, built with the tests.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The program's path.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        // The tests of a profile lie beside its programs: target/PROFILE/deps/TEST.
        let test = std::env::current_exe().expect("a running test has a path");
        let folder = test.ancestors().nth(2).expect("tests lie two folders below their profile's");
        let built = folder.join(format!("program-under-test{}", std::env::consts::EXE_SUFFIX));
        under_its_name(&built, &folder.join("under-test"))
    })
}

/// Gives the program its name, in a folder of its own: other processes may be doing the same.
fn under_its_name(built: &Path, folder: &Path) -> PathBuf {
    fs::create_dir_all(folder).expect("a folder can be made beside the tests");
    let name = format!("skyfront{}", std::env::consts::EXE_SUFFIX);
    let link = folder.join(format!("{name}-{}", std::process::id()));
    fs::hard_link(built, &link).unwrap_or_else(|reason| panic!("{}: {reason}", built.display()));
    let program = folder.join(name);
    fs::rename(&link, &program).expect("a link can be renamed");
    // Where both are one file already, a renaming leaves both.
    let _ = fs::remove_file(link);
    program
}

/// The root of the workspace.
pub fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Runs `skyfront` with arguments and waits for it.
pub fn skyfront<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Output {
    Command::new(program()).args(arguments).output().expect("the program can be started")
}

/// What a run wrote to stderr.
pub fn messages(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder for one test, empty, removed when dropped.
pub struct Folder(PathBuf);

impl Folder {
    /// An empty folder whose name begins with `name`.
    pub fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("skyfront-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a temporary folder can be made");
        Folder(path)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// A path in it, as an argument.
    pub fn file(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }

    /// The names in a folder below it, sorted; empty where there is none.
    pub fn names(&self, below: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.join(below)).into_iter().flatten();
        let mut names: Vec<String> =
            entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
