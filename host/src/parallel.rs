//! The evolution on several processors: bands of rows, one thread each, in step.
//!
//! Before a step every band shows the rows and the tiles at its borders to its neighbours, and
//! what its last step changed; after a barrier all know the same and compute the next step, or
//! stop. A row's new values depend on old rows only and changes are whole numbers, so the result
//! has the same bits for any number of threads.

use crate::planes::thread_can_be_had;
use skyfront_core::arithmetic::Arithmetic;
use skyfront_core::arithmetic::vectors::COLUMNS;
use skyfront_core::front::scheme::{Evolve, Step};
use skyfront_core::front::stop::Change;
use skyfront_core::plane::sweep::{Band, Halo, ring_len, row_stride};
use skyfront_core::plane::tiles::Tiles;
use skyfront_core::run::segmenter::Evolution;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a band shows its neighbours: rows with repeated columns on both sides, and tile flags.
#[derive(Clone, Default)]
struct Border<C> {
    rows: Vec<C>,
    flags: Vec<u8>,
}

/// What a band shows in a step.
#[derive(Clone)]
struct Shown<A: Arithmetic> {
    first: Border<A::Cell>,
    last: Border<A::Cell>,
    change: Change<A>,
}

/// What all threads share; two sets in turn, so that one barrier a step is enough.
struct Shared<A: Arithmetic> {
    shown: [Vec<Mutex<Shown<A>>>; 2],
    barrier: Barrier,
}

/// Moves the front until it stops; `watch` hears of every step and its change. Gives the number
/// of steps and the last change, for [`skyfront_core::run::segmenter::Segmenter::finish_evolution`].
///
/// Where the system does not give so many threads, fewer move the front.
///
/// # Panics
/// Where `watch` does; then all bands stop.
pub fn evolve<A, S>(
    mut evolution: Evolution<'_, A, S>,
    threads: usize,
    watch: &mut dyn FnMut(u32, &Change<A>),
) -> (u32, Change<A>)
where
    A: Arithmetic,
    S: Evolve<A> + Sync,
{
    let mut wanted = threads;
    loop {
        match in_bands(&mut evolution, wanted, watch) {
            Ok(moved) => return moved,
            // Not all of them: what the last ones took may be what else the run needs.
            Err(TooFew(given)) => wanted = given / 2,
        }
    }
}

/// The system gave threads for so many bands only, and nothing has moved.
struct TooFew(usize);

/// Moves the front in at most so many bands, one at least.
fn in_bands<A, S>(
    evolution: &mut Evolution<'_, A, S>,
    threads: usize,
    watch: &mut dyn FnMut(u32, &Change<A>),
) -> Result<(u32, Change<A>), TooFew>
where
    A: Arithmetic,
    S: Evolve<A> + Sync,
{
    let &mut Evolution { ref mut front, speed, width, tile_rows, scheme, rule, settle, regions, max_steps } = evolution;
    let rows = front.len() / width;
    // At least two rows of tiles each: a neighbour's border must not reach through a band.
    let bands = threads.clamp(1, (rows / (2 * tile_rows)).max(1));
    let band_rows = rows.div_ceil(tile_rows).div_ceil(bands) * tile_rows;
    let fronts = bands_of(front, band_rows * width, tile_rows * width);
    let none = Step { settle, change: Change::none(&rule), means: regions.means };
    let nothing = Shown { first: Border::default(), last: Border::default(), change: none.change };
    let set = || fronts.iter().map(|_| Mutex::new(nothing.clone())).collect::<Vec<_>>();
    let shared = Shared { shown: [set(), set()], barrier: Barrier::new(fronts.len()) };
    let work = |index: usize, front: &mut [A::Cell], watch: &mut dyn FnMut(u32, &Change<A>)| {
        let _breaker = Breaker(&shared.barrier);
        let height = front.len() / width;
        let speed = beside(speed, index * band_rows * width..index * band_rows * width + front.len(), width);
        let window = scheme.window();
        let mut ring = vec![A::Cell::default(); ring_len(width, window)];
        let mut flags = vec![0; (width.div_ceil(COLUMNS) + 1) * height.div_ceil(tile_rows)];
        let mut tiles = Tiles::new(&mut flags, width, tile_rows);
        tiles.wake();
        let (mut step, mut regions) = (none, regions);
        for steps in 0.. {
            let shown = &shared.shown[steps as usize % 2];
            show(&mut lock(&shown[index]), front, &tiles, (width, window / 2), step.change);
            shared.barrier.wait().ok()?;
            let change = shown.iter().fold(none.change, |mut sum, shown| {
                sum.merge(&lock(shown).change);
                sum
            });
            if steps > 0 {
                watch(steps, &change);
                if rule.at_rest(&change) || steps == max_steps {
                    return Some((steps, change));
                }
            }
            let before = index.checked_sub(1).map(|band| lock(&shown[band]).last.clone()).unwrap_or_default();
            let after = shown.get(index + 1).map(|band| lock(band).first.clone()).unwrap_or_default();
            if steps > 0 {
                tiles.turn(&before.flags, &after.flags);
                if regions.turn(&change.regions) {
                    tiles.wake();
                }
            }
            step = Step { means: regions.means, ..none };
            let halo = Halo { before: &before.rows, after: &after.rows };
            let mut band = Band { plane: &mut *front, aux: speed, ring: &mut ring, width, halo };
            scheme.advance(&mut band, &mut tiles, 0..height, &mut step);
        }
        None
    };
    std::thread::scope(|scope| {
        let mut bands = fronts.into_iter().enumerate();
        let (own, work) = (bands.next(), &work);
        for (index, front) in bands {
            let helper = move || work(index, front, &mut |_, _| {});
            if !thread_can_be_had() || std::thread::Builder::new().spawn_scoped(scope, helper).is_err() {
                shared.barrier.shatter();
                return Err(TooFew(index));
            }
        }
        // A barrier that breaks later ends in a panic of this scope.
        Ok(own.and_then(|(index, front)| work(index, front, watch)).unwrap_or((0, none.change)))
    })
}

/// The part of the other plane that lies beside `cells` of the front, with a row more on every side where it goes on.
fn beside<C>(plane: &[C], cells: Range<usize>, width: usize) -> &[C] {
    &plane[cells.start.saturating_sub(width)..(cells.end + width).min(plane.len())]
}

/// The front in bands of `size` cells; what is left at the end joins the last band where it is
/// shorter than `least`, so that every band has the rows that its neighbours look at.
fn bands_of<C>(front: &mut [C], size: usize, least: usize) -> Vec<&mut [C]> {
    let mut bands = Vec::new();
    let mut rest = front;
    while rest.len() >= size + least {
        let (band, after) = rest.split_at_mut(size);
        bands.push(band);
        rest = after;
    }
    bands.push(rest);
    bands
}

/// Shows the first and last `radius` rows of a band, the flags of its outer tiles, and a change.
fn show<A: Arithmetic>(
    shown: &mut Shown<A>,
    front: &[A::Cell],
    tiles: &Tiles<'_>,
    (width, radius): (usize, usize),
    change: Change<A>,
) {
    let rows = front.len() / width;
    shown.change = change;
    for (border, first, tile_row) in
        [(&mut shown.first, 0, 0), (&mut shown.last, rows.saturating_sub(radius), tiles.row_at(rows - 1))]
    {
        border.rows.clear();
        for row in front.chunks_exact(width).skip(first).take(radius) {
            let behind = row_stride(width, 2 * radius + 1) - radius - width;
            border.rows.extend(std::iter::repeat_n(row[0], radius));
            border.rows.extend_from_slice(row);
            border.rows.extend(std::iter::repeat_n(row[width - 1], behind));
        }
        border.flags.clear();
        border.flags.extend_from_slice(tiles.border(tile_row));
    }
}

/// The content of a mutex; a thread that panicked while it held one ends the whole scope anyway.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A barrier for short waits: it spins for a while before it lets other threads run.
struct Barrier {
    threads: usize,
    arrived: AtomicUsize,
    generation: AtomicUsize,
    broken: AtomicBool,
}

/// Not all threads will come to the barrier.
struct Broken;

/// Looks at the counter before the processor is given away: about ten microseconds.
const SPINS: u32 = 4000;

impl Barrier {
    fn new(threads: usize) -> Self {
        let zero = || AtomicUsize::new(0);
        Barrier { threads, arrived: zero(), generation: zero(), broken: AtomicBool::new(false) }
    }

    fn wait(&self) -> Result<(), Broken> {
        let generation = self.generation.load(Ordering::Acquire);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.threads {
            self.arrived.store(0, Ordering::Relaxed);
            self.generation.store(generation.wrapping_add(1), Ordering::Release);
            return Ok(());
        }
        let mut spins = 0;
        while self.generation.load(Ordering::Acquire) == generation {
            if self.broken.load(Ordering::Relaxed) {
                return Err(Broken);
            }
            spins += 1;
            if spins < SPINS { std::hint::spin_loop() } else { std::thread::yield_now() }
        }
        Ok(())
    }

    /// Lets all go who wait, now and later.
    fn shatter(&self) {
        self.broken.store(true, Ordering::Relaxed);
    }
}

/// Breaks the barrier when its thread panics, so that none waits for it.
struct Breaker<'a>(&'a Barrier);

impl Drop for Breaker<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.shatter();
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::pipeline::{Drive, segment};
    use skyfront_core::config::Config;
    use skyfront_core::run::outcome::Progress;
    use skyfront_core::run::stage::Stage;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    #[test]
    fn a_panic_in_one_band_ends_all() {
        let pixels: Vec<f32> = (0..128 * 128).map(|n| ((n * 7919) % 101) as f32).collect();
        let mut watch = |progress: &Progress| {
            if let Progress::Working { stage: Stage::Evolve, pass: 3, .. } = progress {
                panic!("as the test wants it");
            }
        };
        let mut drive = Drive { threads: 4, watch: Some(&mut watch), ..Drive::default() };
        let run = || segment(&Config::PAPER_F160, &pixels, 128, 128, &mut drive);
        assert!(catch_unwind(AssertUnwindSafe(run)).is_err());
    }
}
