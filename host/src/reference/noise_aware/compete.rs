//! Borders between sources, and sources in one piece (`default.md`, 6).

use super::light::{ROUND, Shape, light, nearest, on_ellipse, opposite, place, shape};
use super::reopen::alone;
use super::{Judge, Plane, Region, Regions, neighbours};

/// Measures the shapes of sources and lets neighbours compete for pixels, forwards and once backwards.
pub fn compete(image: &Plane, regions: &mut Regions, judge: &Judge) {
    let (width, height) = (image.width(), image.height());
    let shapes = shapes(image, regions);
    for at in (0..width * height).chain((0..width * height).rev()) {
        let mut owner = regions.labels[at];
        for near in neighbours(at, width, height, 4) {
            let other = regions.labels[near];
            if owner == 0 || other == 0 || other == owner {
                continue;
            }
            let owner_is_brighter = regions.sum(owner) >= regions.sum(other);
            let (bright, faint) = if owner_is_brighter { (owner, other) } else { (other, owner) };
            if let Some(host) = own_light(image, regions, (bright, shapes[bright as usize - 1]), at, judge) {
                owner = if judge.exceeds(image.values()[at], 2.0 * host) { faint } else { bright };
            }
        }
        regions.labels[at] = owner;
    }
}

fn shapes(image: &Plane, regions: &Regions) -> Vec<Shape> {
    let mut pixels: Vec<Vec<usize>> = vec![Vec::new(); regions.table.len()];
    for (at, &label) in regions.labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        pixels[label as usize - 1].push(at);
    }
    let told = |at: usize| (place(at, image.width()), image.values()[at].max(0.0));
    let of = |(region, pixels): (&Region, &Vec<usize>)| match region.plateau {
        true => ROUND,
        false => shape(region.centre, pixels.iter().map(|&at| told(at))),
    };
    regions.table.iter().zip(&pixels).map(of).collect()
}

/// The mirrored light of a source, where it is its own and in the frame; else that on its ellipse.
fn own_light(image: &Plane, regions: &Regions, (label, shape): (u32, Shape), at: usize, judge: &Judge) -> Option<f64> {
    let centre = regions.of(label)?.centre;
    let from = place(at, image.width());
    let across = opposite(centre, from);
    let is_own = |seen: f64| {
        let other = nearest(image, across).map_or(0, |at| regions.labels[at]);
        let Some(there) = regions.of(other).filter(|_| other != label) else { return true };
        let foreign = alone(image, [centre, there.centre], across).unwrap_or(0.0);
        !judge.exceeds(foreign, 0.25 * seen)
    };
    let counts = |at: usize| [0, label].contains(&regions.labels[at]);
    light(image, across).filter(|&seen| is_own(seen)).or_else(|| on_ellipse(image, (centre, shape), from, counts))
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
