//! The core's `embedded-hal` part against a simulated FRAM and pin, with faults.

use embedded_hal::spi::SpiDevice;
use skyfront_core::arithmetic::F32;
use skyfront_core::config::Config;
use skyfront_core::hal::{CHUNK, Heartbeat, MapWriter, MemoryError, MemoryFrame, PixelFormat, PollError, SerialMemory};
use skyfront_core::run::extract::{self, Extractor};
use skyfront_core::run::frame::{Frame, SliceFrame};
use skyfront_core::run::memory::{flags_len, ring_cells};
use skyfront_core::run::outcome::Progress;
use skyfront_core::run::segmenter::Segmenter;
use skyfront_core::simulate::{Kind, Sky};
use skyfront_core::sky::view::Known;
use skyfront_workload::fram::{Failed, Fault, Fram, Pin};
use skyfront_workload::run::Planes;
use skyfront_workload::sources;

const WIDTH: usize = 37;
const HEIGHT: usize = 12;
const PIXELS: usize = WIDTH * HEIGHT;
/// Where the image lies: not at a multiple of anything.
const IMAGE: u32 = 0x01_0203;
/// Where the map lies.
const MAP: u32 = 0x01_2001;
const SIZE: usize = 0x01_4000;
/// Rows between two edges of the heartbeat, at most.
const BEAT: usize = 5;
/// The memory of a run.
type Room = Planes<F32, WIDTH, PIXELS, { ring_cells(WIDTH, false) }, { flags_len(WIDTH, HEIGHT) }>;
const FORMATS: [PixelFormat; 3] = [PixelFormat::U8, PixelFormat::U16Le, PixelFormat::U16Be];

/// Whole pixel values of a small sky; 9 stands for "undefined" once.
fn values(format: PixelFormat) -> Vec<u16> {
    let mut sky = Sky::new(Kind::Bright, 5, WIDTH, HEIGHT);
    let mut row = [0.0; WIDTH];
    let scale = f32::from(format.greatest());
    let mut values: Vec<u16> = Vec::new();
    for y in 0..HEIGHT {
        sky.row(y, &mut row).unwrap();
        values.extend(row.map(|v| (20.0 + v * scale) as u16));
    }
    values[5] = 9;
    values
}

/// A memory that holds the image.
fn loaded(format: PixelFormat) -> Vec<u8> {
    let mut bytes = vec![0xAA; SIZE];
    let stored = values(format).into_iter().flat_map(|value| match format {
        PixelFormat::U8 => vec![value as u8],
        PixelFormat::U16Le => value.to_le_bytes().to_vec(),
        PixelFormat::U16Be => value.to_be_bytes().to_vec(),
    });
    bytes.iter_mut().skip(IMAGE as usize).zip(stored).for_each(|(to, from)| *to = from);
    bytes
}

fn frame(fram: Fram<'_>, format: PixelFormat) -> MemoryFrame<Fram<'_>> {
    MemoryFrame::new(SerialMemory::new(fram), IMAGE, WIDTH, HEIGHT, format).unwrap().with_undefined(9)
}

fn as_pixels(values: &[u16]) -> Vec<f32> {
    values.iter().map(|&v| if v == 9 { f32::NAN } else { f32::from(v) }).collect()
}

#[test]
fn rows_come_out_as_they_lie_in_the_memory() {
    for format in FORMATS {
        let mut bytes = loaded(format);
        let mut frame = frame(Fram::new(&mut bytes), format);
        let expected = as_pixels(&values(format));
        let mut row = [0.0; WIDTH];
        for (y, wanted) in expected.chunks(WIDTH).enumerate() {
            frame.row(y, &mut row).unwrap();
            assert_eq!(row.map(f32::to_bits).as_slice(), wanted.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
        }
    }
}

#[test]
fn rows_that_the_image_does_not_have_are_refused() {
    let mut bytes = loaded(PixelFormat::U8);
    let mut frame = frame(Fram::new(&mut bytes), PixelFormat::U8);
    let beyond = frame.row(HEIGHT, &mut [0.0; WIDTH]);
    assert_eq!(beyond, Err(MemoryError::Row { y: HEIGHT, columns: WIDTH }));
    let short = frame.row(0, &mut [0.0; WIDTH - 1]);
    assert_eq!(short, Err(MemoryError::Row { y: 0, columns: WIDTH - 1 }));
}

#[test]
fn ranges_end_with_the_last_24_bit_address() {
    let last = (1 << 24) - PIXELS as u32;
    let mut bytes = [0; 8];
    let memory = SerialMemory::new(Fram::new(&mut bytes));
    let frame = MemoryFrame::new(memory, last, WIDTH, HEIGHT, PixelFormat::U8).unwrap();
    let refused = MemoryFrame::new(frame.release(), last + 1, WIDTH, HEIGHT, PixelFormat::U8);
    assert_eq!(refused.err(), Some(MemoryError::Range { address: last + 1, bytes: PIXELS }));
    let map = MapWriter::new::<Failed>(last, PIXELS, PixelFormat::U16Le);
    assert_eq!(map.err(), Some(MemoryError::Range { address: last, bytes: 2 * PIXELS }));
    let mut memory = SerialMemory::new(Fram::new(&mut bytes));
    let beyond = memory.read(u32::MAX, &mut [0; 2]);
    assert_eq!(beyond, Err(MemoryError::Range { address: u32::MAX, bytes: 2 }));
}

#[test]
fn no_transaction_is_longer_than_a_chunk() {
    struct Longest(usize);
    impl embedded_hal::spi::ErrorType for Longest {
        type Error = Failed;
    }
    impl SpiDevice for Longest {
        fn transaction(&mut self, operations: &mut [embedded_hal::spi::Operation<'_, u8>]) -> Result<(), Failed> {
            use embedded_hal::spi::Operation::{Read, Write};
            let bytes = operations.iter().map(|o| match o {
                Read(read) => read.len(),
                Write(written) => written.len(),
                _ => usize::MAX,
            });
            self.0 = self.0.max(bytes.sum());
            operations.iter_mut().for_each(|o| {
                if let Read(out) = o {
                    out.fill(7)
                }
            });
            Ok(())
        }
    }
    let mut memory = SerialMemory::new(Longest(0));
    memory.read(3, &mut [0; 1000]).unwrap();
    memory.write(3, &[7; 1000]).unwrap();
    assert_eq!(memory.release().0, CHUNK + 4);
}

#[test]
fn labels_come_back_as_written_in_every_format() {
    // Labels as f32 cells hold them, none beyond a byte.
    let labels: Vec<f32> = (0..PIXELS).map(|i| (i % 256) as f32).collect();
    for format in FORMATS {
        let mut bytes = vec![0xAA; SIZE];
        let mut memory = SerialMemory::new(Fram::new(&mut bytes));
        let mut map = MapWriter::new::<Failed>(MAP, PIXELS, format).unwrap();
        while !map.poll(&mut memory, &labels).unwrap() {}
        let end = MAP as usize + PIXELS * format.bytes();
        let stored = bytes[MAP as usize..end].chunks(format.bytes()).map(|label| match format {
            PixelFormat::U8 => u16::from(label[0]),
            PixelFormat::U16Le => u16::from_le_bytes([label[0], label[1]]),
            PixelFormat::U16Be => u16::from_be_bytes([label[0], label[1]]),
        });
        assert!(stored.eq(labels.iter().map(|&label| label as u16)), "{format:?}");
        assert_eq!((bytes[MAP as usize - 1], bytes[end]), (0xAA, 0xAA), "{format:?}: neighbours are untouched");
    }
}

#[test]
fn a_label_beyond_the_format_is_named_and_not_written() {
    let mut bytes = [0xAA; 16];
    let mut memory = SerialMemory::new(Fram::new(&mut bytes));
    let mut map = MapWriter::new::<Failed>(0, 2, PixelFormat::U8).unwrap();
    let refused = map.poll(&mut memory, &[1.0f32, 256.0]);
    assert_eq!(refused, Err(MemoryError::Label { label: 256, greatest: 255 }));
    assert_eq!(bytes, [0xAA; 16]);
}

#[test]
fn wrong_data_on_read_back_is_found_at_its_address_and_can_be_written_again() {
    let labels = [3.0f32; 100];
    let mut bytes = [0; 256];
    let mut fram = Fram::new(&mut bytes);
    // Transactions of a chunk: enable, write, read back. The second chunk's write is number 4.
    fram.fault = Some(Fault::Write(4));
    let mut memory = SerialMemory::new(fram);
    let mut map = MapWriter::new::<Failed>(10, 100, PixelFormat::U16Be).unwrap();
    assert_eq!(map.poll(&mut memory, &labels), Ok(false));
    let address = 10 + 2 * CHUNK as u32 - 1;
    assert_eq!(map.poll(&mut memory, &labels), Err(MemoryError::Mismatch { address, written: 3, read: 2 }));
    assert_eq!(map.written(), CHUNK / 2, "the chunk counts as not written");
    while !map.poll(&mut memory, &labels).unwrap() {}
    assert!(bytes[10..210].chunks(2).all(|label| label == [0, 3]));
}

/// What a run through the devices leaves behind.
#[derive(Debug, PartialEq)]
struct Flight {
    labels: Vec<u32>,
    map: Vec<u8>,
    sources: usize,
    transactions: u32,
    failures: u32,
}

/// Image in, run with heartbeat, map out; whatever fails is called again.
fn through_devices(fault: Option<Fault>) -> Flight {
    let format = PixelFormat::U16Le;
    let mut bytes = loaded(format);
    let mut fram = Fram::new(&mut bytes);
    fram.fault = fault;
    let mut frame = frame(fram, format);
    let mut room = Room::ZERO;
    let mut run = Segmenter::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, room.memory()).unwrap();
    let mut heartbeat = Heartbeat::new(Pin::default(), BEAT);
    let (mut failures, mut polls) = (0, 0);
    loop {
        let (before, _) = run.work();
        let polled = heartbeat.poll(&mut run, &mut frame);
        assert!(run.work().0 - before <= BEAT as u64, "too long without an edge");
        match polled {
            Ok(Progress::Working { .. }) => polls += 1,
            Ok(Progress::Done(_)) => break,
            Err(PollError::Run(skyfront_core::error::Error::Frame(MemoryError::Bus(Failed)))) => failures += 1,
            Err(other) => panic!("unexpected: {other}"),
        }
    }
    assert_eq!(heartbeat.release().edges, polls + 1, "one edge for every poll that went well");
    let mut map = MapWriter::new::<Failed>(MAP, PIXELS, format).unwrap();
    loop {
        match map.poll(frame.memory(), run.front()) {
            Ok(true) => break,
            Ok(false) => {}
            Err(MemoryError::Bus(Failed) | MemoryError::Mismatch { .. }) => failures += 1,
            Err(other) => panic!("unexpected: {other}"),
        }
    }
    let labels = run.front().iter().map(|&cell| cell as u32).collect();
    let sources = run.catalog().len();
    let fram = frame.release().release();
    let map = fram.bytes()[MAP as usize..][..2 * PIXELS].to_vec();
    Flight { labels, map, sources, transactions: fram.transactions, failures }
}

#[test]
fn a_fault_at_any_transaction_is_reported_and_changes_nothing() {
    let clean = through_devices(None);
    assert_eq!(clean.failures, 0);
    assert!(clean.sources > 0, "a sky without sources would prove nothing");
    let stored = clean.map.chunks(2).map(|label| u32::from(u16::from_le_bytes([label[0], label[1]])));
    assert!(stored.eq(clean.labels.iter().copied()));
    for number in 0..clean.transactions {
        let run = through_devices(Some(Fault::Bus(number)));
        assert_eq!(run.failures, 1, "transaction {number} failed");
        assert_eq!((&run.labels, &run.map, run.sources), (&clean.labels, &clean.map, clean.sources));
    }
    // The map's writes come last: of three transactions a chunk, the second one.
    let chunks = (2 * PIXELS).div_ceil(CHUNK) as u32;
    for chunk in 0..chunks {
        let run = through_devices(Some(Fault::Write(clean.transactions - 3 * chunks + 3 * chunk + 1)));
        assert_eq!(run.failures, 1, "chunk {chunk} was damaged");
        assert_eq!(run.map, clean.map);
    }
}

#[test]
fn the_memory_gives_the_same_result_as_a_slice() {
    let pixels = as_pixels(&values(PixelFormat::U16Le));
    let mut room = Room::ZERO;
    let mut run = Segmenter::<F32>::new(&Config::PAPER_F160, WIDTH, HEIGHT, room.memory()).unwrap();
    while !matches!(run.poll(HEIGHT, &mut SliceFrame(&pixels)).unwrap(), Progress::Done(_)) {}
    let labels: Vec<u32> = run.front().iter().map(|&cell| cell as u32).collect();
    assert_eq!(through_devices(None).labels, labels);
}

#[test]
fn a_run_of_the_default_beats_once_a_poll() {
    let mut room = Box::new(sources::Room::<f32>::BLANK);
    let (_, _, work) = room.work();
    let (mut sky, mut pixels) = (Sky::new(Kind::Stars, 7, sources::WIDTH, sources::HEIGHT), Vec::new());
    for y in 0..sources::HEIGHT {
        let mut row = [0.0; sources::WIDTH];
        sky.row(y, &mut row).unwrap();
        pixels.extend(row);
    }
    let mut run = Extractor::new(&Config::NOISE_AWARE, &pixels, sources::WIDTH, Known::default(), work).unwrap();
    let mut heartbeat = Heartbeat::new(Pin::default(), BEAT);
    let mut polls = 1;
    let found = loop {
        match heartbeat.poll_extractor(&mut run).unwrap() {
            extract::Progress::Done(found) => break found,
            _ => polls += 1,
        }
    };
    assert!(found.sources > 0 && polls > 100, "{polls} polls");
    assert_eq!(heartbeat.release().edges, polls);
}

#[test]
fn a_pin_that_fails_is_reported_and_the_beat_is_not_lost() {
    let mut pin = Pin::default();
    pin.stuck = true;
    let mut heartbeat = Heartbeat::new(pin, 5);
    assert_eq!(heartbeat.beat(), Err(Failed));
    heartbeat.beat().unwrap();
    heartbeat.beat().unwrap();
    assert_eq!(heartbeat.release().edges, 2);
}

#[test]
fn errors_say_what_happened_where() {
    let mismatch = MemoryError::<Failed>::Mismatch { address: 0x1234, written: 3, read: 2 };
    assert_eq!(mismatch.to_string(), "wrote 0x03 to 0x1234, but read 0x02");
    let pin: PollError<MemoryError<Failed>, Failed> = PollError::Pin(Failed);
    assert!(pin.to_string().starts_with("the heartbeat's pin: "));
}
