//! `proofmass-lab`: the live bench.

use clap::Parser;
use proofmass_lab::device::Device;
use proofmass_lab::plan::Plan;
use proofmass_lab::practice;
use proofmass_lab::server::Server;
use proofmass_lab::session::Session;
use proofmass_lab::simulated::{Simulated, SimulatedBench, Switch};
use proofmass_lab::text_device::TextDevice;
use proofmass_lab::walk::{Choice, Click};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// Measure, watch and record shaker runs in the browser.
///
/// The plan is the folder of a campaign: its table of runs says what is measured. What is recorded is an ordinary
/// campaign again, for `proofmass calibrate`. The page is served on this machine alone.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Folder of the campaign that is the plan; with --simulate one for practice is made where none is named
    plan: Option<PathBuf>,
    /// Folder that is recorded into; one that was begun goes on
    #[arg(short, long, value_name = "FOLDER", default_value = "measured")]
    output: PathBuf,
    /// Measure on the simulated bench
    #[arg(long, conflicts_with_all = ["device", "adapter"])]
    simulate: bool,
    /// How much faster than real time the simulated bench runs; 0 is as fast as the machine can
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    speed: f64,
    /// Seed of the simulated bench
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Device that speaks lines of text over TCP
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "adapter")]
    device: Option<String>,
    /// Program that speaks lines of text on its standard input and output, and its arguments: the last option
    #[arg(long, value_name = "PROGRAM", num_args = 1.., allow_hyphen_values = true)]
    adapter: Vec<String>,
    /// Least duration of a recording, s
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0)]
    duration: f64,
    /// Largest drive, V [default: a tenth of what the device can give; all of it for the simulated bench]
    #[arg(long, value_name = "V")]
    largest_drive: Option<f64>,
    /// Do not ask before each mounting; the simulated bench mounts by itself
    #[arg(long)]
    no_confirm: bool,
    /// Go on measuring when no page is open
    #[arg(long)]
    unattended: bool,
    /// Begin at once, without the page
    #[arg(long, requires = "unattended")]
    start: bool,
    /// Port of the page; 0 is any that is free
    #[arg(long, default_value_t = 8737)]
    port: u16,
    /// Do not open the browser
    #[arg(long)]
    no_browser: bool,
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("error: {what}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), String> {
    let duration = arguments.duration;
    if !(0.05..=600.0).contains(&duration) {
        return Err(format!(
            "--duration {duration} is out of range: from 0.05 s to 600 s"
        ));
    }
    if !(0.0..=1000.0).contains(&arguments.speed) {
        return Err(format!(
            "--speed {} is out of range: from 0 to 1000",
            arguments.speed
        ));
    }
    let begun = arguments.output.join(proofmass_lab::plan::PLAN).is_file();
    let folder = match &arguments.plan {
        Some(folder) => folder.clone(),
        None if begun => arguments.output.clone(),
        None if arguments.simulate => practice::campaign(&arguments.output, arguments.seed)?,
        None => {
            return Err(
                "no plan is named: give the folder of a campaign, or try --simulate".to_owned(),
            );
        }
    };
    let plan = Plan::open(&folder).map_err(|e| e.to_string())?;
    let (device, switch) = device(&arguments, &plan)?;
    let able = device.identity().drive.unwrap_or(0.0);
    let usual = if arguments.simulate { able } else { 0.1 * able };
    let drive = arguments.largest_drive.unwrap_or(usual);
    if !(drive > 0.0 && drive <= able) {
        return Err(format!(
            "--largest-drive {drive} is out of range: above 0, and at most the {able} V that the device gives"
        ));
    }
    let choice = Choice {
        duration,
        confirm: !(arguments.no_confirm || arguments.simulate),
        attended: !arguments.unattended,
        limits: plan.limits(drive),
    };
    println!(
        "{} runs; drive at most {drive} V, acceleration at most {} m/s²; the drive waits at most two blocks of {:.0} ms",
        plan.runs.len(),
        choice.limits.acceleration,
        1e3 * device.identity().block_seconds()
    );
    let session =
        Session::open(plan, &arguments.output, device, choice).map_err(|e| e.to_string())?;
    let session = Arc::new(session);
    let server = Server::bind(arguments.port, session.clone(), switch)?;
    let ended = session.clone();
    ctrlc::set_handler(move || {
        ended.close();
        println!("the drive is at zero, the folder is written: start again with the same command to go on");
        std::process::exit(0);
    })
    .map_err(|e| format!("signals cannot be listened to: {e}"))?;
    let link = server.link();
    println!("the page: {link}");
    println!("the link holds for this start and this machine; Ctrl-C ends");
    if !arguments.no_browser && !open(&link) {
        println!("no browser could be opened: open the link by hand");
    }
    if arguments.start {
        session.click(Click::Start);
    }
    server
        .serve()
        .map_err(|e| format!("the page cannot be served: {e}"))
}

fn device(arguments: &Arguments, plan: &Plan) -> Result<(Box<dyn Device>, Option<Switch>), String> {
    if arguments.simulate {
        let (seats, frequencies) = plan.grid();
        let mut bench = SimulatedBench::new(seats, frequencies, arguments.seed);
        bench.laboratory.acquisition.sampling_frequency = plan.rate;
        bench.block = (0.04 * plan.rate).round().max(1.0) as usize;
        bench.speed = (arguments.speed > 0.0).then_some(arguments.speed);
        let device = Simulated::new(bench);
        let switch = device.switch();
        return Ok((Box::new(device), Some(switch)));
    }
    let device = match (&arguments.device, arguments.adapter.split_first()) {
        (Some(address), _) => TextDevice::connect(address),
        (None, Some((program, rest))) => TextDevice::adapter(program, rest),
        (None, None) => {
            return Err(
                "no device is named: --device HOST:PORT, --adapter PROGRAM, or --simulate"
                    .to_owned(),
            );
        }
    };
    let device = device.map_err(|e| e.to_string())?;
    Ok((Box::new(device), None))
}

/// Opens the page in the browser of the desktop, where there is one.
fn open(link: &str) -> bool {
    let (program, arguments): (&str, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("rundll32", &["url.dll,FileProtocolHandler"]),
        _ => ("xdg-open", &[]),
    };
    let quiet = std::process::Stdio::null;
    let started = std::process::Command::new(program)
        .args(arguments)
        .arg(link)
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .status();
    started.is_ok_and(|s| s.success())
}
