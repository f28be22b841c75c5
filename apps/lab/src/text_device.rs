//! A device that speaks lines of text: over TCP, or a program on its standard input and output.
//!
//! One line asks, one line answers; the README of this package has the whole protocol.
//!
//! | the bench says | the device answers |
//! |---|---|
//! | `hello 1` | `identity {…}` with the keys of [`Identity`] as JSON |
//! | `start` | `ok` |
//! | `arrange {…}` with the keys of [`Arrangement`] | `ok` |
//! | `drive V V V …`, one block | `block COUNTER OVERLOADED V V V …`, sample by sample with all channels |
//! | `silence` | `ok`, the drive being at zero |
//!
//! `OVERLOADED` is `-`, or the numbers of channels from one joined by commas. `error WHAT` answers anything.

use crate::device::{Arrangement, Block, Device, DeviceError, Identity};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

/// Longest line that is read, bytes.
const LONGEST: u64 = 16 << 20;
/// Patience while nothing is driven.
const HELLO: Duration = Duration::from_secs(5);

/// A device behind two streams of text.
pub struct TextDevice {
    identity: Identity,
    lines: Receiver<Result<String, String>>,
    writer: Box<dyn Write + Send>,
    child: Option<Child>,
    /// Answers that are due to questions nobody waits for any more.
    owed: usize,
}

impl TextDevice {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// Nobody answers there, or not as a device does.
    pub fn connect(address: &str) -> Result<Self, DeviceError> {
        let gone = |e: std::io::Error| DeviceError::Gone(format!("{address}: {e}"));
        let mut last = DeviceError::Gone(format!("{address}: there is no such host"));
        for place in address.to_socket_addrs().map_err(gone)? {
            match TcpStream::connect_timeout(&place, HELLO) {
                Ok(stream) => {
                    stream.set_nodelay(true).map_err(gone)?;
                    // A device that reads nothing must not hold the thread of the drive.
                    stream
                        .set_write_timeout(Some(Duration::from_millis(250)))
                        .map_err(gone)?;
                    let reader = stream.try_clone().map_err(gone)?;
                    return Self::new(reader, Box::new(stream), None);
                }
                Err(e) => last = gone(e),
            }
        }
        Err(last)
    }

    /// Starts a program and talks over its standard input and output; its errors go where those of the bench go.
    ///
    /// # Errors
    /// It cannot be started, or does not answer as a device does.
    pub fn adapter(program: &str, arguments: &[String]) -> Result<Self, DeviceError> {
        let gone = |e: std::io::Error| DeviceError::Gone(format!("{program}: {e}"));
        let mut child = Command::new(program)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(gone)?;
        match (child.stdout.take(), child.stdin.take()) {
            (Some(reader), Some(writer)) => Self::new(reader, Box::new(writer), Some(child)),
            _ => Err(DeviceError::Gone(format!(
                "{program}: it has no standard input"
            ))),
        }
    }

    fn new(
        reader: impl Read + Send + 'static,
        writer: Box<dyn Write + Send>,
        child: Option<Child>,
    ) -> Result<Self, DeviceError> {
        let (to, lines) = sync_channel(4);
        std::thread::spawn(move || {
            let mut reader = BufReader::new(reader);
            loop {
                let mut line = String::new();
                let read = (&mut reader).take(LONGEST).read_line(&mut line);
                let said = match read {
                    Ok(0) => Err("the connection ended".to_owned()),
                    Ok(_) if !line.ends_with('\n') => {
                        Err("a line is cut short or too long".to_owned())
                    }
                    Ok(_) => Ok(line),
                    Err(e) => Err(e.to_string()),
                };
                let over = said.is_err();
                if to.send(said).is_err() || over {
                    return;
                }
            }
        });
        let mut device = Self {
            identity: Identity {
                maker: String::new(),
                model: String::new(),
                serial: String::new(),
                channels: Vec::new(),
                rate: 0.0,
                block: 0,
                full_scale: 0.0,
                drive: None,
                paced: true,
            },
            lines,
            writer,
            child,
            owed: 0,
        };
        let answer = device.ask("hello 1", HELLO)?;
        let json = answer
            .strip_prefix("identity ")
            .ok_or_else(|| nonsense(&answer))?;
        device.identity = serde_json::from_str(json)
            .map_err(|e| DeviceError::Nonsense(format!("its identity cannot be read: {e}")))?;
        device.identity.check()?;
        Ok(device)
    }

    fn ask(&mut self, line: &str, wait: Duration) -> Result<String, DeviceError> {
        let until = Instant::now() + wait;
        let gone = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut => DeviceError::Stalled,
            _ => DeviceError::Gone(e.to_string()),
        };
        self.writer
            .write_all(format!("{line}\n").as_bytes())
            .map_err(gone)?;
        self.writer.flush().map_err(gone)?;
        self.owed += 1;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let answer = match self.lines.recv_timeout(left) {
                Ok(Ok(answer)) => answer,
                Ok(Err(why)) => return Err(DeviceError::Gone(why)),
                Err(RecvTimeoutError::Timeout) => return Err(DeviceError::Stalled),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(DeviceError::Gone("the connection ended".into()));
                }
            };
            self.owed -= 1;
            if self.owed > 0 {
                continue;
            }
            let answer = answer.trim_end();
            return match answer.strip_prefix("error ") {
                Some(what) => Err(DeviceError::Nonsense(format!(
                    "it answers: {}",
                    shortened(what)
                ))),
                None => Ok(answer.to_owned()),
            };
        }
    }

    fn expect_ok(&mut self, line: &str, wait: Duration) -> Result<(), DeviceError> {
        match self.ask(line, wait)?.as_str() {
            "ok" => Ok(()),
            other => Err(nonsense(other)),
        }
    }
}

fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(120).collect()
}

fn nonsense(answer: &str) -> DeviceError {
    DeviceError::Nonsense(format!("an answer that is none: {:?}", shortened(answer)))
}

/// Reads the answer to a drive.
fn block(answer: &str, channels: usize) -> Result<Block, DeviceError> {
    let mut words = answer.split_ascii_whitespace();
    let head = (
        words.next(),
        words.next().and_then(|w| w.parse().ok()),
        words.next(),
    );
    let (Some("block"), Some(first), Some(overloaded)) = head else {
        return Err(nonsense(answer));
    };
    let overloaded = match overloaded {
        "-" => Vec::new(),
        list => {
            let numbers = list
                .split(',')
                .map(|n| n.parse::<usize>().ok()?.checked_sub(1));
            numbers
                .collect::<Option<_>>()
                .ok_or_else(|| nonsense(answer))?
        }
    };
    let mut block = Block {
        first,
        channels: vec![Vec::new(); channels],
        overloaded,
    };
    for (i, word) in words.enumerate() {
        // What is no number is kept as such: the guard ends the run by that name.
        block.channels[i % channels].push(word.parse().unwrap_or(f64::NAN));
    }
    Ok(block)
}

impl Device for TextDevice {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        self.expect_ok("start", HELLO)
    }

    fn arrange(&mut self, arrangement: &Arrangement) -> Result<(), DeviceError> {
        let json =
            serde_json::to_string(arrangement).map_err(|e| DeviceError::Nonsense(e.to_string()))?;
        self.expect_ok(&format!("arrange {json}"), Duration::from_millis(250))
    }

    fn exchange(&mut self, drive: &[f64], wait: Duration) -> Result<Block, DeviceError> {
        let mut line = String::with_capacity(12 * drive.len());
        line.push_str("drive");
        for v in drive {
            line.push_str(&format!(" {v:.6}"));
        }
        let answer = self.ask(&line, wait)?;
        block(&answer, self.identity.channels.len())
    }

    fn silence(&mut self, wait: Duration) -> Result<(), DeviceError> {
        self.expect_ok("silence", wait)
    }
}

impl Drop for TextDevice {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            // Its input is closed by then; a program that goes on is ended.
            self.writer = Box::new(std::io::sink());
            let until = Instant::now() + Duration::from_millis(500);
            while Instant::now() < until && matches!(child.try_wait(), Ok(None)) {
                std::thread::sleep(Duration::from_millis(10));
            }
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
