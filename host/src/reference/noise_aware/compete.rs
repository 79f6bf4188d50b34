//! Borders between sources, and sources in one piece (`default.md`, 6).

use super::light::{Place, ROUND, Shape, opposite, place};
use super::seen::{Between, Roundings, Seeing};
use super::{Plane, Region, Regions, neighbours};

/// Measures the shapes of sources and lets neighbours compete for pixels, forwards and once backwards.
pub fn compete(image: &Plane, regions: &mut Regions) {
    let shapes = shapes(image, regions);
    let centres: Vec<Place> = regions.table.iter().map(|region| region.centre).collect();
    let sums: Vec<f64> = regions.table.iter().map(|region| region.sum).collect();
    let contest = Contest { image, centres: &centres, lights: &sums, shapes: &shapes, roundings: Roundings::NONE };
    let pixels = regions.labels.len();
    for at in (0..pixels).chain((0..pixels).rev()) {
        // Without roundings there is one.
        if let [owner] = contest.owners(&regions.labels, at)[..] {
            regions.labels[at] = owner;
        }
    }
}

/// The shapes of sources: of plateaus circles.
fn shapes(image: &Plane, regions: &Regions) -> Vec<Shape> {
    let centres: Vec<Place> = regions.table.iter().map(|region| region.centre).collect();
    let of = |(region, moments): (&Region, Moments)| if region.plateau { ROUND } else { moments.shape() };
    regions.table.iter().zip(moments(image, &regions.labels, &centres)).map(of).collect()
}

/// The second moments of a source's light around its centre.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    /// Pixels.
    pub pixels: usize,
    /// Along x, of x and y, and along y.
    sums: (f64, f64, f64),
}

impl Moments {
    /// The shape of the isophotes; that of a circle without light.
    pub fn shape(&self) -> Shape {
        let (xx, xy, yy) = self.sums;
        if xx + yy > 0.0 { ((xx - yy) / (xx + yy), 2.0 * xy / (xx + yy)) } else { ROUND }
    }
}

/// Those of all sources, by their labels less 1.
pub fn moments(image: &Plane, labels: &[u32], centres: &[Place]) -> Vec<Moments> {
    let mut found = vec![Moments::default(); centres.len()];
    for (at, &label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        let ((x, y), (centre_x, centre_y)) = (place(at, image.width()), centres[label as usize - 1]);
        let (x, y, light) = (x - centre_x, y - centre_y, image.values()[at].max(0.0));
        let moments = &mut found[label as usize - 1];
        let (xx, xy, yy) = moments.sums;
        moments.sums = (xx + light * x * x, xy + light * x * y, yy + light * y * y);
        moments.pixels += 1;
    }
    found
}

/// Sources that compete.
#[derive(Clone, Copy, Debug)]
pub struct Contest<'a> {
    /// The image that was divided.
    pub image: &'a Plane,
    /// By their labels less 1.
    pub centres: &'a [Place],
    /// Their light in all, or numbers that sort as it does.
    pub lights: &'a [f64],
    /// The shapes of their isophotes.
    pub shapes: &'a [Shape],
    /// What is rounded.
    pub roundings: Roundings,
}

/// What may come of the question whether a pixel has more than twice a source's light.
#[derive(Clone, Copy, Debug, Default)]
struct Answers {
    yes: bool,
    no: bool,
    unknown: bool,
}

impl Contest<'_> {
    /// The sources that may own a pixel, by all that roundings leave open; one without them.
    pub fn owners(&self, labels: &[u32], at: usize) -> Vec<u32> {
        let mut owners = vec![labels[at]];
        for near in neighbours(at, self.image.width(), self.image.height(), 4) {
            let (before, other) = (owners.clone(), labels[near]);
            owners.clear();
            for owner in before.into_iter().flat_map(|owner| self.between(labels, [owner, other], at)) {
                if !owners.contains(&owner) {
                    owners.push(owner);
                }
            }
        }
        owners
    }

    /// Which of its owner and another source may have a pixel.
    fn between(&self, labels: &[u32], [owner, other]: [u32; 2], at: usize) -> Vec<u32> {
        if owner == 0 || other == 0 || other == owner {
            return vec![owner];
        }
        let light = |label: u32| self.lights[label as usize - 1];
        let (bright, faint) = if light(owner) >= light(other) { (owner, other) } else { (other, owner) };
        let Answers { yes, no, unknown } = self.is_beyond(labels, bright, at);
        [(yes, faint), (no, bright), (unknown, owner)]
            .into_iter()
            .filter_map(|(may, label)| may.then_some(label))
            .collect()
    }

    /// Whether a pixel has more than twice the light that a source has there.
    fn is_beyond(&self, labels: &[u32], label: u32, at: usize) -> Answers {
        let (value, mut answers) = (self.image.values()[at], Answers::default());
        let (mirrored, is_certain) = self.mirrored(labels, label, at);
        let lights = if is_certain { Vec::new() } else { self.on_ellipse(labels, label, at) };
        for light in mirrored.map(Some).into_iter().chain(lights) {
            match light {
                Some(light) => {
                    answers.yes |= value > 2.0 * light.low;
                    answers.no |= value <= 2.0 * light.high;
                }
                None => answers.unknown = true,
            }
        }
        answers
    }

    /// A source's mirrored light, where it may be its own and in the frame, and whether it must be.
    fn mirrored(&self, labels: &[u32], label: u32, at: usize) -> (Option<Between>, bool) {
        let (seeing, centre) = (self.seeing(), self.centre(label));
        let across = opposite(centre, place(at, self.image.width()));
        let Some(seen) = seeing.look(across, 0.0) else { return (None, false) };
        let other = seen.pixels.first().map_or(0, |&at| labels[at]);
        if other == 0 || other == label {
            return (Some(seen.light), true);
        }
        let foreign = seeing.alone([centre, self.centre(other)], across);
        let most = Between { low: 0.25 * seen.light.low, high: 0.25 * seen.light.high };
        let most = most.widened(0.5 * self.roundings.grain);
        (Some(seen.light).filter(|_| foreign.low <= most.high), foreign.high <= most.low)
    }

    /// The light on a source's ellipse, its own or the sky's.
    fn on_ellipse(&self, labels: &[u32], label: u32, at: usize) -> Vec<Option<Between>> {
        let (centre, shape) = (self.centre(label), self.shapes[label as usize - 1]);
        let counts = |at: usize| [0, label].contains(&labels[at]);
        self.seeing().on_ellipse((centre, shape), place(at, self.image.width()), counts)
    }

    fn centre(&self, label: u32) -> Place {
        self.centres[label as usize - 1]
    }

    fn seeing(&self) -> Seeing<'_> {
        Seeing { image: self.image, roundings: self.roundings }
    }
}

/// Straightens outlines, once.
pub fn straighten(labels: &[u32], width: usize) -> Vec<u32> {
    let straight = |(at, &own): (usize, &u32)| {
        let near = neighbours(at, width, labels.len() / width, 8).into_iter().map(|near| labels[near]);
        let other = near.clone().find(|&label| label != own).unwrap_or(own);
        let count = |wanted: u32| near.clone().filter(|&label| label == wanted).count();
        if other != own && count(other) >= 6 && count(own) < 3 { other } else { own }
    };
    labels.iter().enumerate().map(straight).collect()
}

/// Makes every source one piece.
pub fn connect(regions: &Regions, width: usize) -> Vec<u32> {
    let labels = &regions.labels;
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    let mut seen = vec![false; labels.len()];
    for first in 0..labels.len() {
        if labels[first] != 0 && !seen[first] {
            pieces.push(piece(labels, &mut seen, width, first));
        }
    }
    // Of each source the piece that stays.
    let mut kept: Vec<Option<&Vec<usize>>> = vec![None; regions.table.len()];
    let size =
        |label: usize, piece: &Vec<usize>| piece.len() * if piece.contains(&regions.table[label].peak) { 4 } else { 1 };
    for piece in &pieces {
        let label = labels[piece[0]] as usize - 1;
        let better = |best: &Vec<usize>| match (size(label, piece), size(label, best)) {
            (new, old) if new == old => piece.contains(&regions.table[label].peak),
            (new, old) => new > old,
        };
        if kept[label].is_none_or(better) {
            kept[label] = Some(piece);
        }
    }
    let mut settled = vec![0; labels.len()];
    for piece in kept.iter().flatten() {
        piece.iter().for_each(|&at| settled[at] = labels[at]);
    }
    let is_loose = |piece: &&Vec<usize>| settled[piece[0]] == 0;
    let mut loose: Vec<&Vec<usize>> = pieces.iter().filter(is_loose).collect();
    for _ in 0..4 {
        loose.retain(|piece| {
            let owner = owner(&settled, width, piece);
            piece.iter().for_each(|&at| settled[at] = owner);
            owner == 0
        });
    }
    settled
}

/// The connected pixels with one label.
fn piece(labels: &[u32], seen: &mut [bool], width: usize, first: usize) -> Vec<usize> {
    seen[first] = true;
    let mut found = vec![first];
    let mut next = 0;
    while next < found.len() {
        for near in neighbours(found[next], width, labels.len() / width, 8) {
            if labels[near] == labels[first] && !seen[near] {
                seen[near] = true;
                found.push(near);
            }
        }
        next += 1;
    }
    found
}

/// The source that a piece touches most, of equals the first met; 0 for none.
fn owner(settled: &[u32], width: usize, piece: &[usize]) -> u32 {
    let near = piece.iter().flat_map(|&at| neighbours(at, width, settled.len() / width, 8));
    let touched: Vec<u32> = near.map(|near| settled[near]).filter(|&label| label != 0).collect();
    let count = |label: u32| touched.iter().filter(|&&other| other == label).count();
    touched.iter().copied().reduce(|best, other| if count(other) > count(best) { other } else { best }).unwrap_or(0)
}
