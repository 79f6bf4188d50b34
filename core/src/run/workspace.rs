//! The caller's memory for a run on signal-to-noise.

use crate::arithmetic::{Fixed14, Level};
use crate::error::Error;
use crate::plane::grid::Grid;
use crate::plane::sort::Keys;
use crate::sky::view::Known;
use crate::sky::{Sky, mesh_cells, signal};
use crate::sources::tree::Region;
use crate::sources::{selection, separate};

/// Nine planes of 32 bits, the mesh and the table of regions.
#[derive(Debug)]
pub struct Workspace<'m, L: Level> {
    /// W x H: signal-to-noise, in the end.
    pub signal: &'m mut [L],
    /// W x H: lightly smoothed, then the matched image.
    pub fine: &'m mut [L],
    /// W x H: smoothed by need.
    pub smooth: &'m mut [L],
    /// W x H: the front, above 0 inside the outlines.
    pub front: &'m mut [L],
    /// W x H: 1 near sources, 0 on sky.
    pub masked: &'m mut [L],
    /// W x H: scratch.
    pub scratch: &'m mut [L],
    /// W x H: the tree; scratch.
    pub parents: &'m mut [u32],
    /// W x H: pixels by brightness; queue.
    pub order: &'m mut [u32],
    /// W x H: the labels.
    pub labels: &'m mut [u32],
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

/// Bytes of a [`Workspace`] with mesh cells `cell` pixels wide: nine planes (signal, fine, smooth, front,
/// masked, scratch, parents, order, labels), the mesh and the regions.
pub const fn bytes(width: usize, height: usize, cell: usize) -> usize {
    9 * 4 * width * height
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
        let levels = [&self.signal, &self.fine, &self.smooth, &self.front, &self.masked, &self.scratch];
        let words = [&self.parents, &self.order, &self.labels].map(|plane| plane.len());
        let maps = [known.background, known.noise].into_iter().flatten().map(<[f32]>::len);
        let lengths = levels.map(|plane| plane.len()).into_iter().chain(words).chain(maps);
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
            masked: self.masked,
            scratch: self.scratch,
            keys: Keys(self.parents, self.order),
            mesh: self.mesh,
        }
    }

    /// What the steps that separate sources need.
    pub(crate) fn separation(&mut self) -> separate::Planes<'_, L> {
        separate::Planes {
            fine: self.fine,
            smooth: self.smooth,
            front: self.front,
            scratch: self.scratch,
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
            masked: self.masked,
            scratch: self.scratch,
            keys: Keys(self.parents, self.order),
            labels: self.labels,
            regions: self.regions.get_mut(..regions).unwrap_or(&mut []),
        }
    }
}
