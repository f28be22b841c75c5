//! Devices that speak lines: over loopback, and as a program of their own.

use crate::walk::{bench, campaign, wait};
use proofmass_lab::device::{Device, DeviceError};
use proofmass_lab::plan::Plan;
use proofmass_lab::session::Session;
use proofmass_lab::simulated::Simulated;
use proofmass_lab::status::Phase;
use proofmass_lab::text_device::TextDevice;
use proofmass_lab::walk::{Choice, Click};
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::time::Duration;

/// Serves a simulated bench as lines of text to one visitor, who is left after some blocks.
fn serve(mut device: Simulated, blocks: usize) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        let mut writer = stream.try_clone().unwrap();
        let mut given = 0;
        for line in BufReader::new(stream).lines() {
            let Ok(line) = line else { return };
            let (word, rest) = line.split_once(' ').unwrap_or((&line, ""));
            let answer = match word {
                "hello" => format!(
                    "identity {}",
                    serde_json::to_string(device.identity()).unwrap()
                ),
                "start" => device.start().map(|()| "ok".to_owned()).unwrap(),
                "silence" => "ok".to_owned(),
                "arrange" => match device.arrange(&serde_json::from_str(rest).unwrap()) {
                    Ok(()) => "ok".to_owned(),
                    Err(e) => format!("error {e}"),
                },
                "drive" => {
                    given += 1;
                    if given > blocks {
                        return;
                    }
                    let drive: Vec<f64> = rest.split(' ').map(|v| v.parse().unwrap()).collect();
                    let block = device.exchange(&drive, Duration::from_secs(1)).unwrap();
                    let mut answer = format!("block {} -", block.first);
                    for i in 0..drive.len() {
                        block
                            .channels
                            .iter()
                            .for_each(|c| answer += &format!(" {}", c[i]));
                    }
                    answer
                }
                other => format!("error unknown word {other}"),
            };
            if writer.write_all(format!("{answer}\n").as_bytes()).is_err() {
                return;
            }
        }
    });
    address
}

#[test]
fn law_a_campaign_over_the_loopback_ends_well_or_by_name() {
    for (blocks, wanted) in [(usize::MAX, Phase::Finished), (60, Phase::Paused)] {
        let (plan, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        campaign(plan.path());
        let plan = Plan::open(plan.path()).unwrap();
        let address = serve(bench(&plan, None), blocks);
        let device = TextDevice::connect(&address).unwrap();
        assert_eq!(
            device.identity().line(),
            "proofmass simulated shaker bench 1"
        );
        let choice = Choice {
            duration: 0.25,
            confirm: false,
            attended: false,
            limits: plan.limits(10.0),
        };
        let session = Session::open(plan, &out.path().join("m"), Box::new(device), choice).unwrap();
        session.click(Click::Start);
        wait("the end", || {
            [Phase::Finished, Phase::Paused].contains(&session.status.lock().phase)
        });
        let status = session.status.lock().clone();
        assert_eq!(status.phase, wanted, "{:?}", status.reason);
        if wanted == Phase::Paused {
            assert!(status.reason.unwrap().contains("the device is gone"));
        }
    }
}

/// The adapter of the examples, in Python, with a shaker of its own.
#[test]
fn law_an_adapter_program_is_a_device() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/adapter.py");
    let device = TextDevice::adapter("python3", &[script.to_owned()]);
    let mut device = match device {
        Err(DeviceError::Gone(why)) if why.contains("No such file") => {
            println!("skipped: there is no python3");
            return;
        }
        other => other.unwrap(),
    };
    let identity = device.identity().clone();
    device.start().unwrap();
    let drive: Vec<f64> = (0..identity.block)
        .map(|i| (i as f64 * 0.1).sin())
        .collect();
    let first = device.exchange(&drive, Duration::from_secs(5)).unwrap();
    let second = device.exchange(&drive, Duration::from_secs(5)).unwrap();
    assert_eq!(second.first, first.first + identity.block as u64);
    assert_eq!(second.channels.len(), identity.channels.len());
    assert!(second.channels[0].iter().any(|v| v.abs() > 0.1));
    device.silence(Duration::from_secs(5)).unwrap();
}

#[test]
fn refuses_programs_and_servers_that_are_no_devices() {
    let echo = TextDevice::adapter("cat", &[]).err();
    assert!(matches!(echo, Some(DeviceError::Nonsense(_))), "{echo:?}");
    let gone = TextDevice::adapter("true", &[]).err();
    assert!(matches!(gone, Some(DeviceError::Gone(_))), "{gone:?}");
    let nobody = TextDevice::connect("127.0.0.1:1").err();
    assert!(matches!(nobody, Some(DeviceError::Gone(_))), "{nobody:?}");
    let odd = TextDevice::connect("no port").err();
    assert!(matches!(odd, Some(DeviceError::Gone(_))), "{odd:?}");
}
