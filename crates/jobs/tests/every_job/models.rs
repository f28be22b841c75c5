//! Questions to models, plans and recordings at rest.

use crate::agreement::{check, figure, states_everywhere};
use crate::support::record;
use crate::{ask, calibrations};
use proofmass_io::{Input, Source};
use proofmass_jobs::campaign::CampaignFile;
use proofmass_jobs::convert::{ConvertData, ConvertFormat, ConvertJob};
use proofmass_jobs::data_sheet;
use proofmass_jobs::device_check::{DeviceCheckData, DeviceCheckJob, DeviceResult};
use proofmass_jobs::device_plan::DevicePlanJob;
use proofmass_jobs::inspect::{InspectData, InspectJob};
use proofmass_jobs::modes::ModesFile;
use proofmass_jobs::noise::{NoiseData, NoiseJob};
use proofmass_jobs::noise_comparison::{NoiseComparisonData, NoiseComparisonJob};
use proofmass_jobs::plan::PlanJob;
use proofmass_jobs::simulate::{
    SimulateJob, SimulatedAxis, SimulatedMultiPosition, SimulatedNoise, SimulatedShaker,
    SimulatedSpuriousMotion, SimulatedTransducer,
};
use proofmass_jobs::uncertainty::UncertaintyJob;
use proofmass_jobs::{
    AnyData, Destination, Gathered, Job, Memory, Sink, Store, StoredResult, Unwatched,
};
use proofmass_noise::{
    NoiseChannel, NoiseLimit, NoiseModel, Sensor, Term, simulate as simulated_noise,
};
use proofmass_shaker::{Acts, Budget, Key, ShakerInput};
use rand::SeedableRng;
use std::sync::Arc;

pub fn budget() -> Budget {
    let run = [Key::Run, Key::Channel];
    Budget::new(vec![
        ShakerInput::new("reading", Acts::OutputModulus, 0.003, &run).type_a(20.0),
        ShakerInput::new("noise", Acts::OutputAdditive, 5e-5, &run),
    ])
    .expect("a budget")
}

pub fn plan(kind: &str) {
    let result = check(kind, &|watch| {
        let mut job = PlanJob::new(budget());
        job.best = Some(12);
        ask(job, &AnyData::None, watch)
    });
    figure(&result, "predicted.csv", 0, "u_real_%");
    check(kind, &|watch| {
        let mut job = PlanJob::new(budget());
        let day = |k: usize| ["one day", "another day"][k % 2].to_owned();
        job.sessions = (0..job.candidates.len()).map(day).collect();
        ask(job, &AnyData::None, watch)
    });
}

pub fn noise(kind: &str) {
    let model = NoiseModel {
        white: 2.5e-3,
        random_walk: 5.0e-4,
        ..NoiseModel::default()
    };
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(11);
    let rate = simulated_noise(&model, 20_000, 50.0, &mut rng).expect("noise");
    check(kind, &|watch| {
        let channel = NoiseChannel {
            name: "acc_x",
            sensor: Some(Sensor::Accelerometer),
            unit: "m/s²",
            rate: &rate,
        };
        let data = NoiseData::samples(vec![channel], 50.0);
        ask(NoiseJob::default(), &AnyData::Noise(data), watch)
    });
    three_sensors(kind);
}

/// Three sensors side by side on one bed, told apart; and the deviation in windows.
fn three_sensors(kind: &str) {
    let white = |white: f64, seed: u64| {
        let model = NoiseModel {
            white,
            ..NoiseModel::default()
        };
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        simulated_noise(&model, 4000, 50.0, &mut rng).expect("noise")
    };
    let rates = [white(1e-3, 5), white(2e-3, 6), white(3e-3, 7)];
    check(kind, &|watch| {
        let channel = |(name, rate)| NoiseChannel {
            name,
            sensor: Some(Sensor::Accelerometer),
            unit: "m/s²",
            rate,
        };
        let rates = rates.iter().map(Vec::as_slice);
        let channels = ["a", "b", "c"].into_iter().zip(rates).map(channel);
        let data = NoiseData::samples(channels.collect(), 50.0);
        let mut job = NoiseJob::default();
        job.options.separate = true;
        job.options.windows = 4;
        ask(job, &AnyData::Noise(data), watch)
    });
}

/// Two units, of which one is noisier, against a limit between them.
pub fn noise_comparison(kind: &str) {
    let unit = |white: f64, seed: u64| {
        let model = NoiseModel {
            white,
            ..NoiseModel::default()
        };
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let rate = simulated_noise(&model, 10_000, 50.0, &mut rng).expect("noise");
        let channel = NoiseChannel {
            name: "acc_x",
            sensor: Some(Sensor::Accelerometer),
            unit: "m/s²",
            rate: &rate,
        };
        let data = NoiseData::samples(vec![channel], 50.0);
        let outcome = NoiseJob::default().evaluate(&data, &Unwatched);
        outcome.expect("an analysis")
    };
    let (quiet, loud) = (unit(1e-3, 3), unit(1.2e-3, 4));
    let result = check(kind, &|watch| {
        let data = NoiseComparisonData {
            results: &[quiet.analysis(), loud.analysis()],
            names: &["quiet", "loud"],
        };
        let mut job = NoiseComparisonJob::default();
        job.limits = vec![NoiseLimit::new(Term::White, 1.1e-3 * 60.0, "m/s/√h")];
        job.temperatures = vec![20.0, 60.0];
        ask(job, &AnyData::NoiseComparison(data), watch)
    });
    let common = figure(&result, "coefficients.csv", 2, "common");
    assert!((1e-3..1.2e-3).contains(&common), "{common}");
}

/// A device by its calibration at rest and on a shaker, and by its noise: one limit of each verdict.
pub fn device_check(kind: &str) {
    let model = NoiseModel {
        white: 1e-3,
        ..NoiseModel::default()
    };
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(3);
    let rate = simulated_noise(&model, 10_000, 50.0, &mut rng).expect("noise");
    let channel = NoiseChannel {
        name: "acc_x",
        sensor: Some(Sensor::Accelerometer),
        unit: "m/s²",
        rate: &rate,
    };
    let data = NoiseData::samples(vec![channel], 50.0);
    let noise = NoiseJob::default().evaluate(&data, &Unwatched);
    let noise = StoredResult::new(record(), &noise.expect("an analysis")).expect("a result");
    let read = |name: &str, result: &StoredResult| {
        let input = Input {
            path: name.to_owned(),
            sha256: name.to_owned(),
            ..Input::default()
        };
        let bytes = result.to_json().expect("JSON");
        DeviceResult::from_json("unit", name, &bytes, input).expect("a result of a device")
    };
    let results = [
        read(
            "unit/calibration/result.json",
            &calibrations::multi_position("multi-position"),
        ),
        read(
            "unit/shaker/result.json",
            &calibrations::shaker_single("shaker-single"),
        ),
        read("unit/noise/result.json", &noise),
    ];
    // The bias of the hand-held example is some counts, its scale 415 counts per m/s².
    let sheet = "[[limit]]\nterm = \"N\"\nmost = 160.0\nunit = \"µg/√Hz\"\n\
                 [[limit]]\nterm = \"B\"\nmost = 0.001\nunit = \"µg\"\n\
                 [[limit]]\ncharacteristic = \"bias\"\nmost = 1\nunit = \"µg\"\n\
                 [[limit]]\ncharacteristic = \"scale\"\nmost = 1e6\nunit = \"mV/g\"\nfrequency_Hz = [1, 1e6]\n\
                 [[limit]]\ncharacteristic = \"resonance\"\nlower = 2\nunit = \"kHz\"\n";
    let sheet = data_sheet::sheet(sheet).expect("a sheet");
    let result = check(kind, &|watch| {
        let mut job = DeviceCheckJob::default();
        job.sheet = sheet.clone();
        let data = DeviceCheckData { results: &results };
        ask(job, &AnyData::DeviceCheck(data), watch)
    });
    // √2 N in µg/√Hz.
    let white = figure(&result, "verdicts.csv", 0, "value");
    assert!((white - 144.2).abs() < 5.0, "{white}");
    let page = result.html().expect("a page");
    for word in ["pass", "fail", "undecided", "not shown", "Failed: 3 of"] {
        assert!(page.contains(word), "{word}");
    }
}

/// A limit of the noise, one of the bias, and one that the reference does not reach.
pub fn device_plan(kind: &str) {
    let sheet = "[[limit]]\nterm = \"N\"\nmost = 160.0\ntypical = 145\nunit = \"µg/√Hz\"\n\
                 [[limit]]\ncharacteristic = \"bias\"\nchannels = [\"x\"]\nmost = 50\nunit = \"mg\"\n\
                 [[limit]]\ncharacteristic = \"scale\"\nnominal = 10\n\"tolerance_%\" = 1\nunit = \"mV/g\"\nfrequency_Hz = [10, 100]\n";
    let sheet = data_sheet::sheet(sheet).expect("a sheet");
    let result = check(kind, &|watch| {
        let mut job = DevicePlanJob::default();
        job.sheet = sheet.clone();
        job.given.rate = Some(50.0);
        job.given.gravity_uncertainty = Some(1e-4);
        job.given.reference_uncertainty = Some(0.5);
        ask(job, &AnyData::None, watch)
    });
    // 15 µg/√Hz over 1 + 1.2816/1.9600.
    let needed = figure(&result, "planned.csv", 0, "U_needed");
    assert!((needed - 9.07).abs() < 0.01, "{needed}");
    let page = result.html().expect("a page");
    assert!(page.contains("out of reach") && page.contains("1 of 3 limits"));
}

pub fn uncertainty(kind: &str) {
    let model = "[[input]]\nname = \"m\"\nunit = \"kg\"\nvalue = 2.0\nu = 0.1\n\
                 [[output]]\nname = \"w\"\nunit = \"kg\"\nexpression = \"2.137 * m\"\n";
    check(kind, &|watch| {
        let job = UncertaintyJob {
            model: proofmass_documents::read_model(model).expect("a model"),
            ..UncertaintyJob::default()
        };
        ask(job, &AnyData::None, watch)
    });
    let all = format!(
        "{model}[[conformity]]\noutput = \"w\"\nupper = 5.0\n\
         [[sweep]]\ninput = \"m\"\nfrom = 1.0\nto = 3.0\nsteps = 3\n\
         [[target]]\noutput = \"w\"\nU = 0.2\n"
    );
    check(kind, &|watch| {
        let mut job = UncertaintyJob {
            model: proofmass_documents::read_model(&all).expect("a model"),
            ..UncertaintyJob::default()
        };
        job.options.effects = true;
        ask(job, &AnyData::None, watch)
    });
}

/// Every scenario; one that is stopped writes nothing.
pub fn simulate(kind: &str) {
    let mut positions = SimulatedMultiPosition::default();
    positions.standstills = 3;
    let mut shaker = SimulatedShaker::default();
    (shaker.phasors, shaker.configurations) = (true, 3);
    shaker.frequencies = vec![160.0];
    let mut spurious = SimulatedSpuriousMotion::default();
    spurious.frequencies = vec![160.0];
    let mut axis = SimulatedAxis::default();
    axis.duration = 0.5;
    let mut transducer = SimulatedTransducer::default();
    transducer.rate = Some(200e3);
    transducer.duration = Some(0.01);
    let mut noise = SimulatedNoise::default();
    noise.duration = 1.0;
    for job in [
        SimulateJob::MultiPosition(positions),
        SimulateJob::Shaker(shaker),
        SimulateJob::SpuriousMotion(spurious),
        SimulateJob::Axis(axis),
        SimulateJob::Transducer(transducer),
        SimulateJob::Noise(noise),
    ] {
        check(kind, &|watch| {
            let files = Gathered::default();
            let answer = ask(job.clone(), &AnyData::Sink(&files as &dyn Sink), watch);
            let written = files.into_memory();
            assert_eq!(answer.is_ok(), written.open("truth.json").is_ok());
            answer
        });
    }
}

pub fn inspect(kind: &str) {
    let result = check(kind, &|watch| {
        let text = "t_s,acc_m/s2\n0,9.81\n0.01,9.82\n0.02,9.80\n";
        let data = InspectData::new(Source::from_bytes("raw.csv", text)?);
        ask(InspectJob::default(), &AnyData::Inspect(data), watch)
    });
    let inspection = result.section("inspection").expect("a section");
    let mean = &inspection["columns"][1]["statistics"]["mean"];
    assert_eq!(mean.as_f64(), Some(9.81));
    states_everywhere(&result, 9.81);
}

pub fn convert(kind: &str) {
    let result = check(kind, &|watch| {
        let mut job = ConvertJob::default();
        job.to = Some(ConvertFormat::Csv);
        let mut written = Vec::new();
        let text = "t (s);acc (m/s²)\n0;9,81\n0,01;9,82\n0,02;9,80\n";
        let open = || Source::from_bytes("raw.csv", text);
        let data = ConvertData::new(vec![&open], Destination::Bytes(&mut written));
        let answer = ask(job, &AnyData::Convert(data), watch);
        // What was stopped left nothing.
        let expected: &[u8] = match answer.is_ok() {
            true => b"time_s,acc_m/s2\n0,9.81\n0.01,9.82\n0.02,9.8\n",
            false => b"",
        };
        assert_eq!(written, expected);
        answer
    });
    let page = result.html().expect("a page");
    assert!(page.contains("3 rows of 2 columns"));
}

/// A wedge of a few elements; the lowest mode is the principal result.
pub fn modes(kind: &str) {
    let text = "[wedge]\nangle_deg = 55\nlength_mm = 70\nwidth_mm = 50\ntoe_mm = 8\nheight_mm = 80\ngluing_mm = -3\n\
                [accelerometer]\nmass_g = 10\nheight_mm = 5\n\
                [modes]\ncount = 2\nunknowns = 3000\naccuracy = 0.3\nsize_mm = 40\n\
                [uncertainty]\nyoung_percent = 2\n";
    let search = format!("{text}[search]\ntrials = 2\n[search.vary]\nwidth_mm = [45, 55]\n");
    let still = search.replace(
        "[search]",
        "[search]\ngoal = \"least-motion\"\nup_to_Hz = 500",
    );
    let glued = format!(
        "{still}[device]\nsize_mm = [10, 10, 10]\n[device.layer]\nthickness_mm = 0.1\nyoung_GPa = [0.5, 2]\npoisson = 0.38\n"
    );
    let read = |text: &str| {
        let store = Memory::new().file("wedge.toml", text);
        let source = CampaignFile::read(Arc::new(store), "wedge.toml").expect("a file");
        ModesFile::of(source).expect("a wedge")
    };
    let two = read(&glued).beside(read(text));
    for file in [read(text), read(&search), two] {
        check(kind, &|watch| {
            ask(file.job.clone(), &AnyData::Modes(file.data()), watch)
        });
    }
}
