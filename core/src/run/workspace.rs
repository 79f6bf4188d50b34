//! The caller's memory for a run on signal-to-noise.

use crate::arithmetic::{Fixed14, Level};
use crate::error::Error;
use crate::plane::grid::Grid;
use crate::plane::mask::{Mask, MaskMut, mask_words};
use crate::plane::smooth::ROOM_ROWS;
use crate::plane::sort::Keys;
use crate::sky::view::Known;
use crate::sky::{Sky, mesh_cells, signal};
use crate::sources::tree::Region;
use crate::sources::{selection, separate};

/// Four planes of 32 bits, two lists as long as one, a mask, some rows, the mesh and the table of regions.
#[derive(Debug)]
pub struct Workspace<'m, L: Level> {
    /// W x H: signal-to-noise, in the end.
    pub signal: &'m mut [L],
    /// W x H: lightly smoothed, then the matched image.
    pub fine: &'m mut [L],
    /// W x H: smoothed by need, then the narrow image.
    pub smooth: &'m mut [L],
    /// W x H: the bits of the front, a [`Level`] above 0 inside the outlines; from the tree on the labels.
    pub labels: &'m mut [u32],
    /// W x H: the tree. What sources have no pixels for is not touched, but for room to sort.
    pub parents: &'m mut [u32],
    /// W x H: pixels by brightness; queue. Touched as the tree is.
    pub order: &'m mut [u32],
    /// [`mask_words`] of the frame: the pixels near sources.
    pub masked: &'m mut [u32],
    /// Old and smoothed rows: [`ROOM_ROWS`] of the frame's width for each band that is worked on at a time.
    pub rows: &'m mut [L],
    /// [`mesh_cells`] of the frame: background and noise, in the end (see [`Mesh::over`](crate::sky::Mesh::over)).
    pub mesh: &'m mut [Sky],
    /// As many as there may be peaks: [`regions`].
    pub regions: &'m mut [Region<L>],
}

/// Regions that a frame can need.
pub const fn regions(width: usize, height: usize) -> usize {
    width * height / 3 + 1
}

const _: () = assert!(size_of::<Region<f32>>() == size_of::<Region<Fixed14>>());

/// Bytes of a [`Workspace`] for one hand with mesh cells `cell` pixels wide: four planes (signal, fine, smooth, labels)
/// and two lists (parents, order), the mask, the rows, the mesh and the regions.
pub const fn bytes(width: usize, height: usize, cell: usize) -> usize {
    6 * 4 * width * height
        + 4 * (mask_words(width * height) + ROOM_ROWS * width)
        + mesh_cells(width, height, cell) * size_of::<Sky>()
        + regions(width, height) * size_of::<Region<f32>>()
}

impl<L: Level> Workspace<'_, L> {
    /// Checks the lengths of the memory and of the maps for a frame of `count` pixels.
    ///
    /// # Errors
    /// [`Error::Size`], [`Error::Length`], or [`Error::Arithmetic`] for a side longer than [`Level::LONGEST`].
    pub(crate) fn check(&self, count: usize, width: usize, cell: usize, known: Known<'_>) -> Result<Grid, Error> {
        let whole = |grid: &Grid| grid.height > 0 && grid.cells() == count && count <= 1 << 30;
        let Some(grid) = Grid::of(count, width).filter(whole) else {
            let height = count.checked_div(width).unwrap_or(0);
            return Err(Error::Size { width, height, least: 1, most_columns: 1 << 30, most_pixels: 1 << 30 });
        };
        if width > L::LONGEST || grid.height > L::LONGEST {
            let reason = "the places of its pixels have 16 bits: no side may be longer than 65536 pixels";
            return Err(Error::Arithmetic { name: L::NAME, reason });
        }
        let (columns, rows) = known.image((width, grid.height));
        let needed = mesh_cells(columns, rows, cell);
        if self.mesh.len() < needed {
            return Err(Error::Length { name: "the mesh", given: self.mesh.len(), needed });
        }
        let levels = [&self.signal, &self.fine, &self.smooth];
        let words = [&self.parents, &self.order, &self.labels].map(|plane| plane.len());
        let maps = [known.background, known.noise].into_iter().flatten().map(<[f32]>::len);
        let lengths = levels.map(|plane| plane.len()).into_iter().chain(words).chain(maps);
        let rooms = [
            ("the mask", self.masked.len(), mask_words(count)),
            ("the rows", self.rows.len(), ROOM_ROWS.saturating_mul(width)),
        ];
        if let Some((name, given, needed)) = rooms.into_iter().find(|&(_, given, needed)| given < needed) {
            return Err(Error::Length { name, given, needed });
        }
        match { lengths }.find(|&given| given != count) {
            Some(given) => Err(Error::Length { name: "a plane or map", given, needed: count }),
            None => Ok(grid),
        }
    }

    /// What the steps of the sky need.
    pub(crate) fn sky(&mut self) -> signal::Planes<'_, L> {
        signal::Planes {
            signal: self.signal,
            fine: self.fine,
            smooth: self.smooth,
            masked: MaskMut(self.masked),
            rows: self.rows,
            keys: Keys(self.parents, self.order),
            mesh: self.mesh,
        }
    }

    /// What the steps that separate sources need.
    pub(crate) fn separation(&mut self) -> separate::Planes<'_, L> {
        separate::Planes {
            fine: self.fine,
            smooth: self.smooth,
            rows: self.rows,
            parents: self.parents,
            order: self.order,
            labels: self.labels,
            regions: self.regions,
        }
    }

    /// What the steps that select sources need, of so many regions.
    pub(crate) fn selection(&mut self, regions: usize) -> selection::Planes<'_, L> {
        selection::Planes {
            signal: self.signal,
            matched: self.fine,
            narrow: self.smooth,
            masked: Mask(self.masked),
            rows: self.rows,
            keys: Keys(self.parents, self.order),
            labels: self.labels,
            regions: self.regions.get_mut(..regions).unwrap_or(&mut []),
        }
    }
}
