//! Where records are tested: a file, and a server of PostgreSQL that the test starts where there is one.

use proofmass_records::Records;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock};

/// A server that ends with the tests.
struct Server {
    /// Held for as long as the tests run.
    _folder: tempfile::TempDir,
    socket: PathBuf,
}

/// The folder of the programs of PostgreSQL, the newest first.
fn programs() -> Option<PathBuf> {
    let mut places: Vec<PathBuf> = std::fs::read_dir("/usr/lib/postgresql")
        .into_iter()
        .flatten()
        .flatten()
        .map(|e| e.path().join("bin"))
        .collect();
    places.sort();
    places.extend(["/usr/local/pgsql/bin", "/usr/local/bin", "/usr/bin"].map(PathBuf::from));
    places
        .into_iter()
        .rev()
        .find(|p| p.join("initdb").is_file() && p.join("pg_ctl").is_file())
}

/// A command as a user that a server may run as: never root.
fn as_user(program: &Path) -> Command {
    let is_root = Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|o| o.stdout == b"0\n");
    let mut command = match is_root {
        true => {
            let mut command = Command::new("setpriv");
            command
                .args(["--reuid=65534", "--regid=65534", "--clear-groups"])
                .arg(program);
            command
        }
        false => Command::new(program),
    };
    command.env("LC_ALL", "C");
    command
}

fn start() -> Result<Server, String> {
    if !cfg!(feature = "postgres") {
        return Err("built without `--features postgres`".to_owned());
    }
    let bin = programs()
        .ok_or("no initdb and pg_ctl in /usr/lib/postgresql/*/bin: install postgresql")?;
    let folder = tempfile::Builder::new()
        .prefix("pm")
        .tempdir_in("/tmp")
        .map_err(|e| e.to_string())?;
    let socket = folder.path().to_path_buf();
    let _ = Command::new("chmod").arg("777").arg(&socket).status();
    let data = socket.join("data");
    let run = |command: &mut Command| -> Result<(), String> {
        let done = command.output().map_err(|e| e.to_string())?;
        match done.status.success() {
            true => Ok(()),
            false => Err(String::from_utf8_lossy(&done.stderr).into_owned()),
        }
    };
    run(as_user(&bin.join("initdb"))
        .args(["-A", "trust", "-U", "lab", "--no-sync", "-E", "UTF8", "-D"])
        .arg(&data))?;
    let options = format!(
        "-k {} -c listen_addresses= -c max_connections=200",
        socket.display()
    );
    // The server keeps the output open: it goes to a file.
    let log = socket.join("log");
    run(as_user(&bin.join("pg_ctl"))
        .args(["-w", "-s", "-o", &options, "-l"])
        .arg(&log)
        .arg("-D")
        .arg(&data)
        .arg("start"))?;
    Ok(Server {
        _folder: folder,
        socket,
    })
}

impl Server {
    fn url(&self, database: &str) -> String {
        let host = self.socket.display().to_string().replace('/', "%2F");
        format!("postgresql://lab@{host}/{database}")
    }
}

/// The one server of this process; it is stopped when the process ends.
fn server() -> Option<&'static Server> {
    static SERVER: OnceLock<Option<Server>> = OnceLock::new();
    let server = SERVER.get_or_init(|| match start() {
        Ok(server) => {
            // A process of its own waits for the end of this one.
            let script = format!(
                "while kill -0 {} 2>/dev/null; do sleep 1; done; kill -INT $(head -1 {}) ; sleep 2; rm -rf {}",
                std::process::id(),
                server.socket.join("data/postmaster.pid").display(),
                server.socket.display()
            );
            let _ = Command::new("setsid").args(["sh", "-c", &script]).stdin(std::process::Stdio::null())
                .stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn();
            Some(server)
        }
        Err(why) => {
            println!("skipped: the tests on PostgreSQL: {why}");
            None
        }
    });
    server.as_ref()
}

/// A new database on the server, where there is one.
pub fn new_database() -> Option<String> {
    static COUNT: Mutex<u32> = Mutex::new(0);
    let server = server()?;
    let number = {
        let mut count = COUNT.lock().unwrap();
        *count += 1;
        *count
    };
    let name = format!("lab{number}");
    let mut client = postgres::Client::connect(&server.url("postgres"), postgres::NoTls).unwrap();
    client
        .batch_execute(&format!("CREATE DATABASE {name}"))
        .unwrap();
    Some(server.url(&name))
}

/// Runs a test on a file, then on a server where there is one. The folder is the test's own.
pub fn each(test: impl Fn(&str, &Path)) {
    let folder = tempfile::tempdir().unwrap();
    test(
        folder.path().join("lab.records").to_str().unwrap(),
        folder.path(),
    );
    if let Some(url) = new_database() {
        let folder = tempfile::tempdir().unwrap();
        test(&url, folder.path());
    }
}

/// New records at a place.
pub fn make(place: &str) -> Records {
    Records::open_or_make(place).unwrap()
}
