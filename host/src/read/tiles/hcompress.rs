//! `HCOMPRESS_1`: the H-transform of a tile, its bit planes as quadtrees (FITS standard 4.0, section 10.4.4;
//! White, Postman and Lattanzi 1992).
//!
//! A two-dimensional Haar transform turns each 2 x 2 block into a sum and three differences, again and again. The
//! coefficients are written bit plane by bit plane, each plane as a quadtree whose nodes of four bits are Huffman coded;
//! signs follow at the end. Here `rows` and `columns` are those of the tile, columns fastest.

use std::num::Wrapping;

use super::bits::{Bits, Exhausted};

/// A coefficient. Broken streams can hold any numbers, so sums wrap.
type Coefficient = Wrapping<i64>;

/// Magic number, rows, columns, scale, sum of all pixels (64 bits), bit planes of the quadrants (a byte each).
const HEAD: usize = 25;
const MAGIC: [u8; 2] = [0xdd, 0x99];
/// Quadtree nodes by the number of bits of their code: the code is an index into what its length adds.
const THREE_BITS: [u8; 4] = [1, 2, 4, 8];
const FOUR_BITS: [u8; 5] = [3, 5, 10, 12, 15];
const FIVE_BITS: [u8; 5] = [6, 7, 9, 11, 13];
const SIX_BITS: [u8; 2] = [0, 14];

/// Why a tile could not be decoded.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Broken {
    /// The stream ended too early.
    Exhausted,
    /// The stream does not begin as HCOMPRESS, or is of another size than the tile.
    Header,
    /// A code that does not exist, or no mark at the end of the bit planes.
    Code,
}

impl From<Exhausted> for Broken {
    fn from(_: Exhausted) -> Self {
        Self::Exhausted
    }
}

/// Decodes a tile of `columns` x `rows` integers, row by row.
pub(super) fn decode(stream: &[u8], columns: usize, rows: usize, out: &mut [i64]) -> Result<(), Broken> {
    let (head, stream) = stream.split_first_chunk::<HEAD>().ok_or(Broken::Exhausted)?;
    let word = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let (size, scale) = ((word(2) as usize, word(6) as usize), Wrapping(i64::from(word(10) as i32)));
    let sum = i64::from(word(14)) << 32 | i64::from(word(18));
    let planes = [head[22], head[23], head[24]];
    if !head.starts_with(&MAGIC) || size != (rows, columns) || planes.iter().any(|&count| count > 62) {
        return Err(Broken::Header);
    }
    let mut bits = Bits::new(stream);
    let mut grid = Grid { values: vec![Wrapping(0); columns * rows], columns, rows };
    grid.read_planes(&mut bits, planes)?;
    grid.read_signs(&mut bits)?;
    grid.values[0] = Wrapping(sum);
    if scale > Wrapping(1) {
        grid.values.iter_mut().for_each(|value| *value *= scale);
    }
    grid.invert();
    out.iter_mut().zip(&grid.values).for_each(|(to, from)| *to = from.0);
    Ok(())
}

/// Coefficients in the order of the transform, at the end the pixels.
struct Grid {
    values: Vec<Coefficient>,
    columns: usize,
    rows: usize,
}

/// A part of the grid: first row and column, number of rows and columns.
struct Quadrant {
    row: usize,
    column: usize,
    rows: usize,
    columns: usize,
}

impl Grid {
    /// The four quadrants (sums, differences along columns, along rows, along both) and their end mark.
    fn read_planes(&mut self, bits: &mut Bits<'_>, planes: [u8; 3]) -> Result<(), Broken> {
        let (upper, left) = (self.rows.div_ceil(2), self.columns.div_ceil(2));
        let (lower, right) = (self.rows / 2, self.columns / 2);
        let quadrants = [
            (Quadrant { row: 0, column: 0, rows: upper, columns: left }, planes[0]),
            (Quadrant { row: 0, column: left, rows: upper, columns: right }, planes[1]),
            (Quadrant { row: upper, column: 0, rows: lower, columns: left }, planes[1]),
            (Quadrant { row: upper, column: left, rows: lower, columns: right }, planes[2]),
        ];
        for (quadrant, planes) in quadrants {
            for plane in (0..planes).rev() {
                let nodes = read_plane(bits, quadrant.rows, quadrant.columns)?;
                self.add_plane(&quadrant, plane.into(), &nodes);
            }
        }
        if bits.take(4)? == 0 { Ok(()) } else { Err(Broken::Code) }
    }

    /// Sets one bit of every coefficient of a quadrant from the last level of its tree.
    fn add_plane(&mut self, quadrant: &Quadrant, plane: u32, nodes: &[u8]) {
        let across = quadrant.columns.div_ceil(2);
        for y in 0..quadrant.rows {
            let start = (quadrant.row + y) * self.columns + quadrant.column;
            let line = &mut self.values[start..start + quadrant.columns];
            let nodes = &nodes[y / 2 * across..][..across];
            for (x, value) in line.iter_mut().enumerate() {
                *value |= Wrapping(i64::from(child(nodes[x / 2], y, x)) << plane);
            }
        }
    }

    /// One bit for every coefficient that is not zero.
    fn read_signs(&mut self, bits: &mut Bits<'_>) -> Result<(), Exhausted> {
        bits.align();
        for value in self.values.iter_mut().filter(|value| value.0 != 0) {
            if bits.take(1)? == 1 {
                *value = -*value;
            }
        }
        Ok(())
    }

    /// The inverse H-transform: from one sum to blocks of 2 x 2, and so on to the pixels.
    fn invert(&mut self) {
        let levels = levels(self.rows.max(self.columns));
        if levels == 0 {
            return;
        }
        self.values[0] = round(self.values[0], levels + 1);
        for level in (0..levels).rev() {
            let (rows, columns) = (self.rows.div_ceil(1 << level), self.columns.div_ceil(1 << level));
            self.interleave(rows, columns);
            for y in (0..rows).step_by(2) {
                for x in (0..columns).step_by(2) {
                    self.expand(y, x, (y + 1 < rows, x + 1 < columns), level);
                }
            }
        }
    }

    /// Brings sums and differences, which lie in halves, side by side, along rows and then along columns.
    fn interleave(&mut self, rows: usize, columns: usize) {
        let mut scratch = vec![Wrapping(0); rows.max(columns)];
        for line in self.values.chunks_mut(self.columns).take(rows) {
            let line = &mut line[..columns];
            for (n, value) in line.iter().enumerate() {
                scratch[shuffled(n, columns)] = *value;
            }
            line.copy_from_slice(&scratch[..columns]);
        }
        for x in 0..columns {
            for n in 0..rows {
                scratch[shuffled(n, rows)] = self.values[n * self.columns + x];
            }
            for (n, value) in scratch[..rows].iter().enumerate() {
                self.values[n * self.columns + x] = *value;
            }
        }
    }

    /// One block: a sum and up to three differences become up to four values.
    ///
    /// The low bits of a difference were not written where those of the others imply them; they are put back first.
    fn expand(&mut self, y: usize, x: usize, (below, beside): (bool, bool), level: u32) {
        let zero = Wrapping(0);
        let corner = y * self.columns + x;
        let (right, down) = (corner + 1, corner + self.columns);
        let bit = Wrapping(1i64 << level);
        let mut sum = self.values[corner];
        let mut along_y = if below { round(self.values[down], level + 1) } else { zero };
        let mut along_x = if beside { round(self.values[right], level + 1) } else { zero };
        let both = if below && beside { round(self.values[down + 1], level) } else { zero };
        let low = both & bit;
        along_y = if along_y >= zero { along_y - low } else { along_y + low };
        along_x = if along_x >= zero { along_x - low } else { along_x + low };
        let odd = (both ^ along_y ^ along_x) & (bit + bit);
        sum = match sum >= zero {
            true => sum + low - odd,
            false if low == zero => sum + odd,
            false => sum + low - odd,
        };
        let shift = if level == 0 { 2 } else { 1 };
        self.values[corner] = (sum - along_y - along_x + both) >> shift;
        if beside {
            self.values[right] = (sum - along_y + along_x - both) >> shift;
        }
        if below {
            self.values[down] = (sum + along_y - along_x - both) >> shift;
        }
        if below && beside {
            self.values[down + 1] = (sum + along_y + along_x + both) >> shift;
        }
    }
}

/// Rounds to a multiple of 2^bits, halves away from zero for positive and towards it for negative numbers.
fn round(value: Coefficient, bits: u32) -> Coefficient {
    let unit = 1i64 << bits;
    let half = if value >= Wrapping(0) { unit / 2 } else { (unit / 2 - 1).max(0) };
    (value + Wrapping(half)) & Wrapping(-unit)
}

/// Where element `n` of a line of sums followed by differences belongs when they alternate.
fn shuffled(n: usize, length: usize) -> usize {
    let sums = length.div_ceil(2);
    if n < sums { 2 * n } else { 2 * (n - sums) + 1 }
}

/// The smallest `n` with 2^n >= size.
fn levels(size: usize) -> u32 {
    size.max(1).next_power_of_two().trailing_zeros()
}

/// The bit of a node that belongs to the pixel at (y, x): of four, the highest is the first.
fn child(node: u8, y: usize, x: usize) -> u8 {
    node >> (3 - (2 * (y % 2) + x % 2)) & 1
}

/// One bit plane as the nodes of its last level, row by row: written directly, or as a quadtree from the root down.
fn read_plane(bits: &mut Bits<'_>, rows: usize, columns: usize) -> Result<Vec<u8>, Broken> {
    match bits.take(4)? {
        0 => (0..rows.div_ceil(2) * columns.div_ceil(2)).map(|_| Ok(bits.take(4)? as u8)).collect(),
        0xf => read_tree(bits, rows, columns),
        _ => Err(Broken::Code),
    }
}

fn read_tree(bits: &mut Bits<'_>, rows: usize, columns: usize) -> Result<Vec<u8>, Broken> {
    let mut nodes = vec![read_node(bits)?];
    let mut across = 1;
    for level in (1..levels(rows.max(columns))).rev() {
        let (height, width) = (rows.div_ceil(1 << level), columns.div_ceil(1 << level));
        let mut next = Vec::with_capacity(height * width);
        for y in 0..height {
            next.extend((0..width).map(|x| child(nodes[y / 2 * across + x / 2], y, x)));
        }
        // The nodes of a level come last first, and only those that are not empty.
        for node in next.iter_mut().rev().filter(|node| **node != 0) {
            *node = read_node(bits)?;
        }
        (nodes, across) = (next, width);
    }
    Ok(nodes)
}

/// A node of the quadtree, 3 to 6 bits.
fn read_node(bits: &mut Bits<'_>) -> Result<u8, Exhausted> {
    let mut code = bits.take(3)? as usize;
    for (first, nodes) in [(0, &THREE_BITS[..]), (8, &FOUR_BITS[..]), (26, &FIVE_BITS[..]), (62, &SIX_BITS[..])] {
        if let Some(&node) = code.checked_sub(first).and_then(|index| nodes.get(index)) {
            return Ok(node);
        }
        code = code << 1 | bits.take(1)? as usize;
    }
    Err(Exhausted)
}
