//! Memory for the planes of a frame, and for a run.

use skyfront_core::arithmetic::{Arithmetic, Bits, Cell, Level};
use skyfront_core::config::{Config, Scheme};
use skyfront_core::front::bands::{Band, Bands};
use skyfront_core::plane::mask::mask_words;
use skyfront_core::plane::smooth::ROOM_ROWS;
use skyfront_core::run::memory::{Memory, flags_len, ring_cells};
use skyfront_core::run::workspace::Workspace;
use skyfront_core::sky::otsu::{BINS, Histogram};
use skyfront_core::sky::{Sky, mesh_cells};
use skyfront_core::sources::catalog::Source;
use skyfront_core::sources::tree::Region;

/// The memory of one run: as many elements as the core asks for, and not one more.
#[derive(Debug)]
pub struct Room<A: Arithmetic> {
    /// The image plane.
    pub image: Vec<A::Cell>,
    /// The front plane.
    pub front: Vec<A::Cell>,
    /// The catalogue.
    pub sources: Vec<Source>,
    ring: Vec<A::Cell>,
    tiles: Vec<u8>,
    samples: Vec<f32>,
    counts: Box<Histogram>,
}

impl<A: Arithmetic> Room<A> {
    /// Room for a frame and a catalogue of `sources`.
    pub fn new(config: &Config, width: usize, height: usize, sources: usize) -> Self {
        Room::full_of(0, config, width, height, sources)
    }

    /// The same, with the bits of `pattern` in every element: a run must not depend on them.
    pub fn full_of(pattern: u32, config: &Config, width: usize, height: usize, sources: usize) -> Self {
        let cell = A::Cell::from_bits(pattern);
        Room {
            image: plane(width * height, cell),
            front: plane(width * height, cell),
            sources: plane(sources, Source::empty(pattern)),
            ring: vec![cell; ring_cells(width, config.scheme == Scheme::SlCurvature)],
            tiles: vec![pattern as u8; flags_len(width, height)],
            samples: vec![f32::from(pattern as u16); width],
            counts: Box::new(Histogram([pattern; BINS])),
        }
    }

    /// The slices for a segmenter.
    pub fn memory(&mut self) -> Memory<'_, A> {
        Memory {
            image: &mut self.image,
            front: &mut self.front,
            ring: &mut self.ring,
            tiles: &mut self.tiles,
            samples: &mut self.samples,
            counts: &mut self.counts,
            sources: &mut self.sources,
        }
    }
}

/// The memory for further bands of a run ([`skyfront_core::front::bands`]).
#[derive(Debug)]
pub struct BandRoom<A: Arithmetic> {
    planes: Vec<A::Cell>,
    each: Vec<Band>,
}

impl<A: Arithmetic> BandRoom<A> {
    /// Room for so many bands of so many pixels, the first of them included.
    pub fn new(bands: usize, pixels: usize) -> Self {
        BandRoom { planes: plane(bands * pixels, A::Cell::BLANK), each: vec![Band::NEW; bands] }
    }

    /// The slices for a segmenter.
    pub fn bands(&mut self) -> Bands<'_, A> {
        Bands { planes: &mut self.planes, each: &mut self.each }
    }
}

/// The memory of a run on signal-to-noise.
#[derive(Debug)]
pub struct SignalRoom<L: Level> {
    /// Signal, fine and smooth, as in a [`Workspace`].
    pub levels: [Vec<L>; 3],
    /// The front, then the labels.
    pub labels: Vec<u32>,
    /// Parents and order; of their memory the system gives as much as is used.
    lists: [Vec<u32>; 2],
    masked: Vec<u32>,
    rows: Vec<L>,
    /// The mesh.
    pub mesh: Vec<Sky>,
    /// The table of regions.
    pub regions: Vec<Region<L>>,
}

impl<L: Level> SignalRoom<L> {
    /// Room for a frame of `count` pixels in rows of `columns`, with so many regions, for so many threads; `image` has
    /// the columns and rows of the mesh's frame.
    pub fn new(
        config: &Config,
        (count, columns): (usize, usize),
        (width, height): (usize, usize),
        regions: usize,
        threads: usize,
    ) -> Self {
        SignalRoom {
            levels: [(); 3].map(|()| in_large_pages(zeros(count))),
            labels: in_large_pages(vec![0; count]),
            lists: [(); 2].map(|()| list(count)),
            masked: vec![0; mask_words(count)],
            rows: vec![L::BLANK; room_rows(count / columns.max(1), threads) * columns],
            mesh: vec![Sky::UNKNOWN; mesh_cells(width, height, config.sky.cell())],
            regions: in_some_large_pages(blank_regions(regions), count),
        }
    }

    /// The slices for an extractor.
    pub fn workspace(&mut self) -> Workspace<'_, L> {
        let ([signal, fine, smooth], [parents, order]) = (&mut self.levels, &mut self.lists);
        let SignalRoom { labels, masked, rows, mesh, regions, .. } = self;
        Workspace { signal, fine, smooth, labels, parents, order, masked, rows, mesh, regions }
    }
}

/// A plane of zeros, which the steps are the first to touch.
fn zeros<L: Level>(count: usize) -> Vec<L> {
    let zeros = Box::<[L]>::new_zeroed_slice(count);
    // SAFETY: a level of which all bits are 0 is the number 0, in single precision and in fixed point.
    unsafe { zeros.assume_init() }.into_vec()
}

/// A list as long as a plane, of which as much is touched as is used.
fn list(count: usize) -> Vec<u32> {
    in_some_large_pages(vec![0; count], count)
}

/// The same, for memory of which a part is touched: only with so many pixels that a part of a page is little beside it.
fn in_some_large_pages<T>(list: Vec<T>, pixels: usize) -> Vec<T> {
    const MANY: usize = 1 << 23;
    if pixels < MANY { list } else { in_large_pages(list) }
}

/// A plane that nobody has touched, in large pages where the system has them.
fn in_large_pages<T>(mut plane: Vec<T>) -> Vec<T> {
    ask_for_large_pages(&mut plane);
    plane
}

/// Regions that are [`Region::BLANK`]. Of a table of zeros the system gives as much as is written to.
fn blank_regions<L: Level>(count: usize) -> Vec<Region<L>> {
    let zeros = Box::<[Region<L>]>::new_zeroed_slice(count);
    // SAFETY: a region of which all bits are 0 is a blank one: it is made of numbers.
    unsafe { zeros.assume_init() }.into_vec()
}

/// Bands of rows for each thread: who is done early takes another.
const BANDS: usize = 2;

/// Rows that so many threads work in: for one band at least, and no more than [`most_room_rows`].
fn room_rows(height: usize, threads: usize) -> usize {
    let bands = if threads > 1 { BANDS * threads } else { 1 };
    ROOM_ROWS * bands.min(most_room_rows(height) / ROOM_ROWS)
}

/// The most rows that threads work in: an eighth of a frame.
pub const fn most_room_rows(height: usize) -> usize {
    if height / 8 > ROOM_ROWS { height / 8 } else { ROOM_ROWS }
}

/// Whether the system gives so many bytes now.
pub fn can_be_had(bytes: u64) -> bool {
    let mut room: Vec<u8> = Vec::new();
    let given = usize::try_from(bytes).is_ok_and(|bytes| room.try_reserve_exact(bytes).is_ok());
    // Or the compiler leaves out an allocation that nobody uses.
    std::hint::black_box(&room);
    given
}

/// Whether another thread leaves the others what they still need: its stack, the 64 MB that the heap may keep back and
/// give no stack, and some planes.
pub fn thread_can_be_had() -> bool {
    const SPARE: u64 = 96_000_000;
    can_be_had(SPARE)
}

/// A plane of `len` cells, in large pages where the system has them: the front touches every row
/// of a frame again and again, and ordinary pages are too many for the processor's page table.
pub fn plane<T: Copy>(len: usize, cell: T) -> Vec<T> {
    let mut plane = room_for(len);
    plane.resize(len, cell);
    plane
}

/// Room for a plane of `len` numbers that are written once, in large pages where the system has them: to get
/// it in ordinary pages takes ten times as long as to write to it.
pub fn room_for<T>(len: usize) -> Vec<T> {
    let mut plane: Vec<T> = Vec::with_capacity(len);
    ask_for_large_pages(&mut plane);
    plane
}

/// Asks for large pages in the memory of a plane, best before it is written to.
#[cfg(target_os = "linux")]
pub(crate) fn ask_for_large_pages<T>(plane: &mut Vec<T>) {
    const PAGE: usize = 4096;
    let from = plane.as_mut_ptr() as usize;
    let to = from + plane.capacity() * size_of::<T>();
    let (first, last) = (from.next_multiple_of(PAGE), to / PAGE * PAGE);
    if first < last {
        // SAFETY: whole pages inside an allocation of ours; the advice changes no content, and
        // where it is refused nothing is lost.
        unsafe { libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn ask_for_large_pages<T>(_: &mut Vec<T>) {}

#[cfg(test)]
mod tests {
    #[test]
    fn memory_that_no_machine_has_cannot_be_had() {
        assert!(super::can_be_had(1 << 20));
        assert!(!super::can_be_had(1 << 60));
        assert!(!super::can_be_had(u64::MAX));
    }

    #[test]
    fn planes_are_filled_and_as_long_as_asked() {
        for len in [0, 1, 1023, 3_000_000] {
            assert_eq!(super::plane(len, 1.5f32), vec![1.5; len]);
        }
    }
}
