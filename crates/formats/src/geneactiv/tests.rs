use crate::RemarkKind;
use crate::stream::Clock;
use crate::stream::tests::{columns, open, survives};

const HEADER: &str = "Device Identity\r\nDevice Type:GENEActiv \0\r\n\r\nSubject Info\r\nSubject Code:nobody\r\n\
    Calibration Data\r\nx gain:25270\r\nx offset:-1846\r\ny gain:25100\r\ny offset:-474\r\nz gain:24829\r\n\
    z offset:1167\r\nVolts:54\r\nLux:997\r\n\r\nNumber of Pages:2\r\n";

/// A page that repeats one sample: x, y, z, light and button.
fn page(sequence: u64, second: u64, [x, y, z]: [i16; 3], light: u16, button: u16) -> String {
    let twelve = |v: i16| format!("{:03X}", v & 0xFFF);
    let sample = [x, y, z].map(twelve).concat() + &format!("{:03X}", light << 2 | button << 1);
    format!(
        "Recorded Data\r\nSequence Number:{sequence}\r\nPage Time:2024-02-29 23:59:{second:02}:500\r\n\
         Temperature:2{}.5\r\nMeasurement Frequency:50.0\r\n{}\r\n",
        sequence % 10,
        sample.repeat(300)
    )
}

#[test]
fn known_pages_and_their_scaling() {
    // The published example of the layout: raw -17, -246, -6 and light 9.
    let pages = page(0, 10, [-17, -246, -6], 9, 0) + &page(1, 16, [2047, -2048, 0], 0, 1);
    let container = open((HEADER.to_owned() + &pages).as_bytes()).unwrap();
    assert_eq!(container.remarks(), []);
    let stream = &container.streams()[0];
    let (hz, start_s) = (50.0, 0.0);
    assert_eq!(
        (stream.rows, stream.clock),
        (600, Clock::Rate { hz, start_s })
    );
    let units: Vec<_> = stream.channels.iter().map(|c| c.unit.as_deref()).collect();
    let wanted = [
        Some("g"),
        Some("g"),
        Some("g"),
        Some("lux"),
        None,
        Some("°C"),
    ];
    assert_eq!(units, wanted);
    assert!(!format!("{stream:?}").contains("nobody"));
    let all = columns(container, 0);
    let first = [
        0.005_778,
        -0.961_195,
        -0.071_167,
        9.0 * 997.0 / 54.0,
        0.0,
        20.5,
    ];
    for (column, wanted) in all.iter().zip(first) {
        assert!((column[0] - wanted).abs() < 6e-7, "{} {wanted}", column[0]);
    }
    assert_eq!((all[4][599], all[5][599]), (1.0, 21.5));
    let exact = (204_700.0 + 1846.0) / 25_270.0;
    assert!((all[0][300] - exact).abs() <= 2.0 * f64::EPSILON * exact);
    let stored = open((HEADER.to_owned() + &pages).as_bytes()).unwrap();
    let stored = columns(stored.without_scaling(), 0);
    assert_eq!(
        [stored[0][0], stored[1][300], stored[3][0]],
        [-17.0, -2048.0, 9.0]
    );
}

#[test]
fn known_damaged_missing_and_cut_pages() {
    let still = [0, 0, 256];
    let pages = [0, 1, 2, 4].map(|i| page(i, 6 * i, still, 0, 0));
    let whole = HEADER.to_owned() + &pages.concat();
    // The fourth page is not there: its time is a gap.
    let container = open(whole.as_bytes()).unwrap();
    let all = columns(container, 0);
    assert_eq!(
        (all[6].len(), all[6][899], all[6][900]),
        (1200, 899.0 / 50.0, 24.0)
    );
    // A digit of the second page is none.
    let at = whole.match_indices("100000").nth(500).unwrap().0;
    let mut broken = whole.clone().into_bytes();
    broken[at] = b'G';
    let container = open(&broken).unwrap();
    let remark = &container.remarks()[0];
    assert_eq!(remark.kind, RemarkKind::Damaged);
    assert!(remark.text.starts_with("1 pages"));
    let all = columns(container, 0);
    assert_eq!((all[6].len(), all[6][300]), (900, 12.0));
    // The last page ends behind its second sample.
    let short = whole.len() - 2 - 3600 + 27;
    let container = open(&whole.as_bytes()[..short]).unwrap();
    let remark = &container.remarks()[0];
    assert_eq!(remark.kind, RemarkKind::Cut);
    let place = whole.rfind("Recorded").unwrap();
    assert!(
        remark.text.ends_with(&format!("byte {place}")),
        "{}",
        remark.text
    );
    assert_eq!(container.streams()[0].rows, 902);
    let more = open((HEADER.replace("Pages:2", "Pages:9") + &pages[0]).as_bytes()).unwrap();
    assert!(more.remarks()[0].text.contains("of the 9"));
}

/// Pages at steps of 5.5 and 6 s, rounded down to half seconds: 300 samples in 5.75 s, where 50 Hz are stated.
#[test]
fn known_rate_of_the_times_of_the_pages() {
    let time = |i: u64| {
        let half = (i as f64 * 11.5).floor() as u64;
        let (second, thousandths) = (half / 2, 500 * (half % 2));
        format!("00:{:02}:{:02}:{thousandths:03}", second / 60, second % 60)
    };
    let pages = (0..120).map(|i| page(i, 0, [0; 3], 0, 0).replace("23:59:00:500", &time(i)));
    let file = HEADER.to_owned() + &pages.collect::<String>();
    let container = open(file.as_bytes()).unwrap();
    let Clock::Rate { hz, .. } = container.streams()[0].clock else {
        panic!("{:?}", container.streams()[0].clock);
    };
    // Half seconds are a uniform error of 0.5/√12 s; its part in a slope over 119 pages is some 1e-5.
    assert!((hz - 300.0 / 5.75).abs() < 1e-4 * hz, "{hz}");
}

#[test]
fn known_seed_survives() {
    let seed = include_bytes!("../../tests/seeds/one.geneactiv");
    let page = page(7, 10, [-17, -246, -6], 9, 1);
    let cut = HEADER.len() + page.len() - 2 - 3600 + 40;
    assert_eq!(&seed[..], &(HEADER.to_owned() + &page).as_bytes()[..cut]);
    survives(seed);
}
