//! Whole sessions: plan, recordings, result.

use proofmass::jobs::simulate::{SimulateJob, SimulatedShaker};
use proofmass::jobs::{Job, Sink, Unwatched};
use proofmass_lab::clock::today;
use proofmass_lab::evaluation::evaluate;
use proofmass_lab::plan::Plan;
use proofmass_lab::session::Session;
use proofmass_lab::simulated::{Fault, Simulated, SimulatedBench, Switch};
use proofmass_lab::status::Phase;
use proofmass_lab::walk::{Choice, Click};
use std::path::Path;
use std::time::{Duration, Instant};

struct Disk<'a>(&'a Path);

impl Sink for Disk<'_> {
    fn write(&self, name: &str, bytes: Vec<u8>) -> proofmass::io::Result<()> {
        std::fs::write(self.0.join(name), bytes).expect("a disk");
        Ok(())
    }
}

/// The campaign that `proofmass simulate shaker` writes, small.
pub fn campaign(folder: &Path) {
    let mut shaker = SimulatedShaker::default();
    shaker.frequencies = vec![80.0, 160.0];
    shaker.configurations = 6;
    shaker.sampling_rate = 10_240.0;
    shaker.duration = 0.1;
    let sink = Disk(folder);
    SimulateJob::Shaker(shaker)
        .evaluate(&(&sink as &dyn Sink), &Unwatched)
        .expect("a campaign");
}

pub fn bench(plan: &Plan, speed: Option<f64>) -> Simulated {
    let (seats, frequencies) = plan.grid();
    let mut bench = SimulatedBench::new(seats, frequencies, 1);
    bench.laboratory.acquisition.sampling_frequency = plan.rate;
    bench.block = 512;
    bench.speed = speed;
    Simulated::new(bench)
}

/// A session on a plan, as fast as the machine can.
pub fn session(plan: &Path, folder: &Path, speed: Option<f64>, confirm: bool) -> (Session, Switch) {
    let plan = Plan::open(plan).expect("a plan");
    let limits = plan.limits(10.0);
    let device = bench(&plan, speed);
    let switch = device.switch();
    let choice = Choice {
        duration: 0.25,
        confirm,
        attended: false,
        limits,
    };
    let session = Session::open(plan, folder, Box::new(device), choice).expect("a session");
    (session, switch)
}

pub fn wait(what: &str, mut over: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !over() {
        assert!(
            begun.elapsed() < Duration::from_secs(100),
            "{what} did not come"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A whole campaign: the result of the live bench is that of the desk on the recorded folder, bit for bit.
#[test]
fn law_the_result_is_that_of_the_desk_on_the_recorded_folder() {
    let (plan, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    campaign(plan.path());
    let folder = out.path().join("measured");
    let (session, _) = session(plan.path(), &folder, None, false);
    session.click(Click::Start);
    wait("the end of the plan", || {
        let status = session.status.lock().clone();
        assert_ne!(status.phase, Phase::Paused, "{:?}", status.reason);
        status.phase == Phase::Finished
    });
    wait("the result", || {
        let known = session.evaluated();
        assert!(
            known.at_work.is_some() || known.lacks.is_none(),
            "{:?}",
            known.lacks
        );
        known.result.as_ref().is_some_and(|(_, runs)| *runs == 12)
    });
    let live = session.evaluated().result.clone().unwrap().0;
    session.close();
    let desk = evaluate(&folder, &today(), &Unwatched).unwrap();
    assert_eq!(live.to_json().unwrap(), desk.to_json().unwrap());
    assert_eq!(live.files().unwrap(), desk.files().unwrap());
    // The truth of the simulation is within twice the expanded uncertainty.
    let truth = std::fs::read_to_string(plan.path().join("truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&truth).unwrap();
    let wanted = &truth["frequencies"][1]["S_V_per_m_per_s2"][2][2];
    let part = |i: usize| wanted[i].as_f64().unwrap();
    let wanted = part(0).hypot(part(1));
    let stated = desk.quantities();
    let main = stated
        .iter()
        .find(|q| q.name == "S.zz.modulus[frequency=160]")
        .unwrap();
    assert!((main.value - wanted).abs() < 2.0 * main.expanded);
    // No file of the lab is torn or hidden.
    let names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(!names.iter().any(|n| n.ends_with(".part")), "{names:?}");
}

/// What was cut short is kept and marked; the next start goes on.
#[test]
fn law_an_ended_run_is_kept_and_the_campaign_goes_on() {
    let (plan, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    campaign(plan.path());
    let folder = out.path().join("measured");
    let (first, switch) = session(plan.path(), &folder, Some(4.0), false);
    first.click(Click::Start);
    wait("a recording", || first.shared.live().phase == "recording");
    switch.set(Fault::CableOff);
    wait("the pause", || first.status.lock().phase == Phase::Paused);
    let reason = first.status.lock().reason.clone().unwrap();
    assert!(reason.contains("reference gives no signal"), "{reason}");
    let log = std::fs::read_to_string(folder.join("lab-log.csv")).unwrap();
    assert!(log.contains("reference-lost"), "{log}");
    // The same session measures the run again.
    first.click(Click::Start);
    wait("two runs", || first.status.lock().done >= 2);
    first.close();
    let rows = |folder: &Path| {
        std::fs::read_to_string(folder.join("runs.csv"))
            .unwrap()
            .lines()
            .count()
            - 1
    };
    let before = rows(&folder);
    assert!((2..12).contains(&before));
    // A kill leaves a torn file behind: a run that is not in the table, and one without its name.
    let begun = Plan::open(&folder).unwrap();
    let left = begun
        .runs
        .iter()
        .find(|r| !folder.join(&r.file).exists())
        .unwrap();
    std::fs::write(
        folder.join(format!(".{}.part", left.file)),
        [0u8; 16 * 100 + 7],
    )
    .unwrap();
    let (second, _) = session(&folder, &folder, None, false);
    assert_eq!(rows(&folder), before);
    let log = std::fs::read_to_string(folder.join("lab-log.csv")).unwrap();
    assert!(log.contains("killed") && log.contains(",100,"), "{log}");
    second.click(Click::Start);
    wait("the end of the plan", || {
        second.status.lock().phase == Phase::Finished
    });
    second.close();
    assert_eq!(rows(&folder), 12);
    assert!(evaluate(&folder, "2026-01-01", &Unwatched).is_ok());
}

#[test]
fn law_the_operator_is_asked_for_every_mounting() {
    let (plan, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    campaign(plan.path());
    let folder = out.path().join("measured");
    let (session, _) = session(plan.path(), &folder, None, true);
    session.click(Click::Start);
    for mounting in 0..6 {
        wait("the question", || {
            session.status.lock().phase == Phase::Mounting
        });
        assert_eq!(session.status.lock().done, 2 * mounting);
        assert!(!session.shared.driving());
        session.click(Click::Mounted);
        wait("the measurement", || {
            session.status.lock().phase != Phase::Mounting
        });
    }
    wait("the end", || session.status.lock().phase == Phase::Finished);
}

#[test]
fn refuses_folders_plans_and_devices_that_do_not_fit() {
    let plan = tempfile::tempdir().unwrap();
    campaign(plan.path());
    let read = |folder: &Path| {
        Plan::open(folder)
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    let out = tempfile::tempdir().unwrap();
    std::fs::write(out.path().join("notes.txt"), "mine").unwrap();
    let opened = Plan::open(plan.path()).unwrap();
    let choice = Choice {
        duration: 0.25,
        confirm: false,
        attended: false,
        limits: opened.limits(10.0),
    };
    let device = bench(&opened, None);
    let taken = Session::open(opened.clone(), out.path(), Box::new(device), choice)
        .err()
        .unwrap();
    assert!(taken.to_string().contains("not empty"), "{taken}");
    // A second process, or a second session, does not record into the same folder.
    let folder = out.path().join("measured");
    let first = Session::open(
        opened.clone(),
        &folder,
        Box::new(bench(&opened, None)),
        choice,
    )
    .unwrap();
    let second = Session::open(
        opened.clone(),
        &folder,
        Box::new(bench(&opened, None)),
        choice,
    )
    .err()
    .unwrap();
    assert!(
        second.to_string().contains("another live bench"),
        "{second}"
    );
    drop(first);
    let mut faster = opened.clone();
    faster.rate = 51_200.0;
    let wrong = Session::open(
        faster,
        &out.path().join("b"),
        Box::new(bench(&opened, None)),
        choice,
    )
    .err()
    .unwrap();
    assert!(wrong.to_string().contains("51200 Hz"), "{wrong}");
    let runs = std::fs::read_to_string(plan.path().join("runs.csv")).unwrap();
    for (from, to, what) in [
        ("run-01.f32", "../run-01.f32", "plain file name"),
        ("run-01.f32", "/etc/passwd", "plain file name"),
        ("run-01.f32", "lab-plan.csv", "plain file name"),
        (",80.0,", ",NaN,", "no number"),
        (",80.0,", ",80000,", "out of range"),
    ] {
        std::fs::write(plan.path().join("runs.csv"), runs.replacen(from, to, 1)).unwrap();
        let said = read(plan.path());
        assert!(said.contains(what), "{from} → {to}: {said}");
    }
    assert!(read(out.path()).contains("campaign.toml"));
}
