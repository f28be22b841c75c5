use super::*;
use crate::stream::tests::{columns, open};
use crate::{Clock, Container};

fn samples() -> Vec<f64> {
    let numbers = (0..1000).map(|i| (f64::from(i) * 0.37).sin() * 9.806_65);
    numbers.collect()
}

fn clock(container: &Container) -> (f64, f64) {
    match container.streams()[0].clock {
        Clock::Rate { hz, start_s } => (hz, start_s),
        other => panic!("{other:?}"),
    }
}

#[test]
fn law_what_is_written_is_read_again() {
    let numbers = samples();
    for form in [
        WavForm::Int16,
        WavForm::Int24,
        WavForm::Int32,
        WavForm::Float32,
        WavForm::Float64,
    ] {
        let full = 2_f64.powi(8 * form.size() as i32 - 1);
        let scaled = numbers.iter().map(|v| match form.is_whole() {
            true => (v / 10.0 * full).trunc(),
            false => *v,
        });
        let scaled: Vec<f64> = scaled.collect();
        let mut file = wav_head(form, 2, 25_600, 1000).unwrap();
        for v in &scaled {
            form.put(*v, &mut file);
            form.put(-*v, &mut file);
        }
        let container = open(&file).unwrap();
        assert!(container.remarks().is_empty(), "{form:?}");
        assert_eq!(clock(&container), (25_600.0, 0.0));
        let wanted: Vec<f64> = scaled.iter().map(|v| form.stored(*v).unwrap()).collect();
        let read = columns(container, 0);
        assert_eq!(read[0], wanted, "{form:?}");
        assert!(read[1].iter().zip(&wanted).all(|(a, b)| *a == -b));
    }
    let mut file = npy_head(500, 2);
    assert_eq!(file.len() % 64, 0);
    put_doubles(numbers.clone(), &mut file);
    let read = columns(open(&file).unwrap(), 0);
    assert!(read[0].iter().eq(numbers.iter().step_by(2)));
    let mut file = Vec::new();
    for (name, unit) in [("acc_x", Some("m/s2")), ("supply of the sensor", None)] {
        file.extend(uff_head(&UffSignal {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
            acceleration: unit.is_some(),
            start_s: 0.5,
            step_s: 1.0 / 25_600.0,
            rows: 1000,
        }));
        put_doubles(numbers.clone(), &mut file);
        file.extend(UFF_END);
    }
    let container = open(&file).unwrap();
    assert!(container.remarks().is_empty(), "{:?}", container.remarks());
    let stream = &container.streams()[0];
    let names: Vec<&str> = stream.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["response acc_x", "response supply of"]);
    assert_eq!(stream.channels[0].unit.as_deref(), Some("m/s2"));
    let (hz, start_s) = clock(&container);
    assert!((hz / 25_600.0 - 1.0).abs() < 1e-7 && start_s == 0.5, "{hz}");
    assert_eq!(columns(container, 0), [numbers.clone(), numbers]);
}

#[test]
fn known_long_form_and_numbers_that_do_not_fit() {
    // Two channels of doubles, 2³² bytes and more: the sizes stand in ds64.
    let rows = 1 << 28;
    let head = wav_head(WavForm::Float64, 2, 1000, rows).unwrap();
    assert!(head.starts_with(b"RF64\xFF\xFF\xFF\xFFWAVEds64\x1C\0\0\0"));
    assert_eq!(head[28..36], (16 * rows).to_le_bytes());
    let container = open(&[&head[..], &[0; 160]].concat()).unwrap();
    assert_eq!(container.streams()[0].rows, 10);
    assert_eq!(WavForm::Int16.stored(32_767.0), Some(32_767.0));
    assert_eq!(WavForm::Int16.stored(32_768.0), None);
    assert_eq!(WavForm::Int24.stored(0.5), None);
    assert!(wav_head(WavForm::Int16, 70_000, 1000, 1).is_err());
}
