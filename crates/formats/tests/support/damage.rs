//! Damaged copies of a file, and what reading each of them costs.

use peak_alloc::PeakAlloc;
use proofmass_formats::Container;
use std::collections::BTreeSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Files up to so many bytes are damaged at every byte, larger ones at so many places.
const EVERY_BYTE: usize = 4096;
const PLACES: usize = 2000;
/// Streams of a file that are read to their end.
const STREAMS: usize = 8;

/// What reading a file costs at most.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    pub seconds: f64,
    /// Heap above the bytes of the file.
    pub bytes: usize,
}

/// The worst of all damaged copies of a file.
#[derive(Debug, Default)]
pub struct Worst {
    pub copies: usize,
    /// With the damage that did it.
    pub seconds: (f64, String),
    pub bytes: (usize, String),
    pub panics: Vec<String>,
}

/// One reading at a time: the heap is that of all threads.
static ALONE: Mutex<()> = Mutex::new(());

/// Opens the bytes and reads each stream with all its channels; the cost of the dearest of these readings.
pub fn read(bytes: &[u8]) -> Cost {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let bytes: Arc<[u8]> = bytes.into();
    let mut cost = Cost::default();
    let mut stream = 0;
    loop {
        HEAP.reset_peak_usage();
        let (before, start) = (HEAP.current_usage(), Instant::now());
        let streams = read_stream(&bytes, stream);
        cost.seconds = cost.seconds.max(start.elapsed().as_secs_f64());
        let above = HEAP.peak_usage().saturating_sub(before);
        cost.bytes = cost.bytes.max(above.saturating_sub(bytes.len()));
        stream += 1;
        if stream >= streams.min(STREAMS) {
            return cost;
        }
    }
}

/// Reads one stream; how many there are.
fn read_stream(bytes: &Arc<[u8]>, stream: usize) -> usize {
    let Ok(container) = Container::open(Box::new(Cursor::new(bytes.clone()))) else {
        return 0;
    };
    let streams = container.streams().len();
    let Some(about) = container.streams().get(stream) else {
        return streams;
    };
    let (total, channels) = (about.rows, about.channels.len());
    let chosen: Vec<usize> = (0..channels).collect();
    let mut rows = container.rows(stream, &chosen).expect("it is there");
    let (mut block, mut seen) = (vec![Vec::new(); channels], 0);
    while let Ok(n) = rows.next_block(&mut block) {
        assert!(block.iter().all(|column| column.len() == n));
        seen += n as u64;
        if n == 0 {
            assert_eq!(seen, total, "rows of stream {stream}");
            break;
        }
    }
    streams
}

/// Places of a file of so many bytes: all, or evenly spread with others between them that follow from a fixed seed.
pub fn places(length: usize, most: usize) -> Vec<usize> {
    if length <= EVERY_BYTE.min(most) {
        return (0..length).collect();
    }
    let even = (0..most / 2).map(|i| i * length / (most / 2));
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let seeded = (0..most / 2).map(|_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % length as u64) as usize
    });
    let all: BTreeSet<usize> = even.chain(seeded).collect();
    all.into_iter().collect()
}

/// Cuts a file and inverts bytes of it, at all places or at so many.
pub fn damage(file: &[u8], most: Option<usize>) -> Worst {
    let mut worst = Worst::default();
    let most = most.unwrap_or(match file.len() <= EVERY_BYTE {
        true => file.len(),
        false => PLACES,
    });
    let mut inverted = file.to_vec();
    worst.look("whole".to_owned(), file);
    for at in places(file.len(), most) {
        worst.look(format!("cut at byte {at}"), &file[..at]);
        inverted[at] ^= 0xFF;
        worst.look(format!("byte {at} inverted"), &inverted);
        inverted[at] ^= 0xFF;
    }
    worst
}

impl Worst {
    /// Reads one copy.
    pub fn look(&mut self, what: String, bytes: &[u8]) {
        self.copies += 1;
        match catch_unwind(AssertUnwindSafe(|| read(bytes))) {
            Ok(cost) => {
                if cost.seconds > self.seconds.0 {
                    self.seconds = (cost.seconds, what.clone());
                }
                if cost.bytes > self.bytes.0 {
                    self.bytes = (cost.bytes, what);
                }
            }
            Err(_) => self.panics.push(what),
        }
    }
}
