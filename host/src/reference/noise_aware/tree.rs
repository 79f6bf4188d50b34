//! The tree of level sets (`default.md`, 5).

use super::super::segments::label;
use super::light::{around, mirrored, nearest, opposite, place, vertex};
use super::photon::grown;
use super::{Connectivity, Judge, Plane, Settings, neighbours};

/// What may become a source.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its brightest pixel.
    pub peak: usize,
    /// The light there.
    pub value: f64,
    /// Pixels, in the tree.
    pub area: usize,
    /// Light in all.
    pub sum: f64,
    /// Its centre.
    pub centre: (f64, f64),
    /// Whether it ends in a plateau.
    pub plateau: bool,
    /// A pixel of the brightest part that was divided from it.
    pub divided: Option<usize>,
}

impl Region {
    /// Nothing is known of it.
    pub const BLANK: Region =
        Region { peak: 0, value: 0.0, area: 0, sum: 0.0, centre: (0.0, 0.0), plateau: false, divided: None };

    /// Remembers a part, if it is the brightest.
    pub fn divide(&mut self, image: &Plane, part: usize) {
        let bright = |at: usize| image.values()[at];
        if self.divided.is_none_or(|known| bright(part) > bright(known)) {
            self.divided = Some(part);
        }
    }
}

/// Regions, and which pixels belong to them: label n is the region of index n - 1, and 0 is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    /// Row-major.
    pub labels: Vec<u32>,
    /// In the order in which they were met.
    pub table: Vec<Region>,
}

impl Regions {
    /// The region of a label.
    pub fn of(&self, label: u32) -> Option<&Region> {
        self.table.get((label as usize).wrapping_sub(1))
    }

    /// The light of a label in all; 0 of none.
    pub fn sum(&self, label: u32) -> f64 {
        self.of(label).map_or(0.0, |region| region.sum)
    }
}

/// The connected components of the pixels `inside`.
pub fn components(inside: &[bool], width: usize, connectivity: Connectivity) -> Regions {
    let (labels, count) = label(inside, width, connectivity, 1);
    Regions { labels, table: vec![Region::BLANK; count as usize] }
}

/// The parts of the pixels `inside`.
pub fn tree(image: &Plane, inside: &[bool], photon: f64, settings: &Settings, judge: &Judge) -> Regions {
    let (width, height, values) = (image.width(), image.height(), image.values());
    let mut order: Vec<usize> = (0..values.len()).filter(|&at| inside[at]).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let mut table: Vec<Region> = Vec::new();
    // The region of each pixel that was taken, and the one that each region has become part of.
    let mut taken: Vec<Option<usize>> = vec![None; values.len()];
    let mut hosts: Vec<usize> = Vec::new();
    for at in order {
        let near: Vec<usize> = neighbours(at, width, height, settings.connectivity.neighbours())
            .into_iter()
            .filter(|&near| taken[near].is_some())
            .collect();
        let host_of = |hosts: &[usize], near: usize| {
            let mut region = taken[near].unwrap_or(0);
            while hosts[region] != region {
                region = hosts[region];
            }
            region
        };
        let brightest =
            near.iter().copied().reduce(|best, other| if values[other] > values[best] { other } else { best });
        let Some(brightest) = brightest else {
            let value = values[at];
            taken[at] = Some(table.len());
            hosts.push(table.len());
            let centre = vertex(image, at, judge);
            table.push(Region { peak: at, value, area: 1, sum: value, centre, plateau: false, divided: None });
            continue;
        };
        let mut meeting: Vec<usize> = near.iter().map(|&near| host_of(&hosts, near)).collect();
        meeting.sort_by(|&a, &b| table[b].value.total_cmp(&table[a].value).then(table[a].peak.cmp(&table[b].peak)));
        meeting.dedup();
        let host = meeting[0];
        for &other in &meeting[1..] {
            let faint = table[other].clone();
            let is_foreign = |near: usize| taken[near].is_some() && host_of(&hosts, near) != host;
            if stands_apart((image, &is_foreign), [&table[host], &faint], values[at], photon, settings, judge) {
                let peak = table[host].peak;
                table[other].divide(image, peak);
                table[host].divide(image, faint.peak);
                continue;
            }
            hosts[other] = host;
            table[other].area = 0;
            table[host].area += faint.area;
            table[host].sum += faint.sum;
            if let Some(part) = faint.divided {
                table[host].divide(image, part);
            }
        }
        let own = host_of(&hosts, brightest);
        taken[at] = Some(own);
        table[own].area += 1;
        table[own].sum += values[at];
    }
    let label = |at: usize| {
        let mut region = taken[at]?;
        while hosts[region] != region {
            region = hosts[region];
        }
        (table[region].area >= 3).then_some(region as u32 + 1)
    };
    Regions { labels: (0..values.len()).map(|at| label(at).unwrap_or(0)).collect(), table }
}

/// Whether the fainter of two regions that meet stays a source of its own; `is_foreign` tells the pixels of
/// any region but the brighter.
fn stands_apart(
    (image, is_foreign): (&Plane, &dyn Fn(usize) -> bool),
    [bright, faint]: [&Region; 2],
    saddle: f64,
    photon: f64,
    settings: &Settings,
    judge: &Judge,
) -> bool {
    let (above, noise, width) = (faint.sum - saddle * faint.area as f64, grown(photon, saddle), image.width());
    let is_own = |at: &usize| {
        let place = place(*at, width);
        let mut host = mirrored(image, bright.centre, place).unwrap_or(0.0);
        if nearest(image, opposite(bright.centre, place)).is_some_and(is_foreign) {
            host = host.min(around(image, bright.centre, place));
        }
        judge.exceeds(image.values()[*at], 2.0 * host)
    };
    faint.area >= 3
        && judge.exceeds(above, settings.branch * noise)
        && judge.exceeds(above, settings.contrast * bright.sum)
        && judge.exceeds(faint.value - saddle, noise.max(0.15 * saddle))
        && {
            let around = neighbours(faint.peak, width, image.height(), 8);
            around.into_iter().chain([faint.peak]).filter(is_own).count() >= 5
        }
}
