//! What hosts do not explain (`default.md`, 6).

use super::light::{Place, around, light, mirrored, nearest, opposite, place};
use super::photon::grown;
use super::{Judge, Plane, Region, Regions, Settings, neighbours};

/// The farthest distance along an axis at which the typical source is known.
const FAR: isize = 24;

/// The light of the frame's typical source, by the distance from its centre, as parts of its peak.
#[derive(Clone, Debug, PartialEq)]
pub struct Typical(Option<Plane>);

impl Typical {
    /// Of the regions before any was reopened; `area` of each is that above half its peak.
    pub fn of(image: &Plane, regions: &Regions, noise: f64) -> Typical {
        let stands = |region: &&Region| region.area > 0 && !region.plateau && region.value > 100.0 * noise;
        let mut bright: Vec<&Region> = regions.table.iter().filter(stands).collect();
        bright.sort_by(|a, b| b.value.total_cmp(&a.value));
        bright.truncate(64);
        let side = 2 * FAR as usize + 1;
        let quartile = |i: isize, j: isize| {
            let part = |region: &&Region| {
                let place = (region.centre.0 + (i - FAR) as f64, region.centre.1 + (j - FAR) as f64);
                Some(light(image, place)? / region.value)
            };
            let mut parts: Vec<f64> = bright.iter().filter_map(part).collect();
            parts.sort_by(f64::total_cmp);
            parts.get(parts.len() / 4).copied().unwrap_or(0.0)
        };
        Typical((bright.len() >= 12).then(|| Plane::from_fn(side, side, quartile)))
    }

    /// The most light that a region has at a place if it is typical.
    fn light(&self, region: &Region, at: Place) -> f64 {
        let Some(plane) = &self.0 else { return 0.0 };
        let off = |at: f64, centre: f64| (at - centre + 0.5).floor() as isize;
        let (i, j) = (off(at.0, region.centre.0), off(at.1, region.centre.1));
        let known = i.abs() <= FAR && j.abs() <= FAR;
        if known { 1.3 * region.value.max(0.0) * plane.at(i + FAR, j + FAR) } else { 0.0 }
    }
}

/// What `other` alone has at a place.
pub fn alone(image: &Plane, [host, other]: [Place; 2], at: Place) -> Option<f64> {
    let across = opposite(other, at);
    let theirs = light(image, opposite(host, across)).unwrap_or(0.0).min(around(image, host, across));
    light(image, across).map(|light| (light - theirs).max(0.0))
}

/// Everything that reopening looks at.
pub struct Scene<'a> {
    /// The image that was divided.
    pub image: &'a Plane,
    /// The typical source.
    pub typical: &'a Typical,
    /// The noise of the fine image.
    pub noise: f64,
    /// The photon noise.
    pub photon: f64,
    /// What is asked of sources.
    pub settings: &'a Settings,
    /// Who decides.
    pub judge: &'a Judge,
}

impl Scene<'_> {
    fn place(&self, at: usize) -> Place {
        place(at, self.image.width())
    }

    fn host_light(&self, host: &Region, at: usize) -> Option<f64> {
        let mirrored = mirrored(self.image, host.centre, self.place(at))?;
        Some(mirrored.max(self.typical.light(host, self.place(at))))
    }

    /// The most that the host has where its centre is off by 0.2 px.
    fn most_host_light(&self, host: &Region, at: usize) -> Option<f64> {
        let (x, y) = opposite(host.centre, self.place(at));
        let beside = [(x - 0.2, y), (x + 0.2, y), (x, y - 0.2), (x, y + 0.2)];
        let exact = self.host_light(host, at)?;
        Some(beside.into_iter().filter_map(|place| light(self.image, place)).fold(exact, f64::max))
    }

    /// Whether a pixel has significantly more than so much light.
    fn exceeds(&self, at: usize, light: f64) -> bool {
        let v = self.image.values()[at];
        self.judge.exceeds(v - light, self.settings.excess * self.noise * grown(self.photon, v))
    }

    /// Makes regions of what hosts do not explain, once.
    pub fn reopen(&self, regions: &mut Regions) {
        let opens = |at: usize| {
            let host = regions.of(regions.labels[at]).filter(|host| !host.plateau)?;
            let light = self.host_light(host, at)?;
            let v = self.image.values()[at];
            Some(self.judge.exceeds(v, 2.5 * light) && self.exceeds(at, light))
        };
        let mut open: Vec<bool> = (0..regions.labels.len()).map(|at| opens(at).unwrap_or(false)).collect();
        for first in 0..open.len() {
            if open[first] {
                let group = self.group(first, &mut open, &regions.labels);
                self.divide(&group, regions);
            }
        }
    }

    /// The open pixels of one host that are connected to the first; they are closed.
    fn group(&self, first: usize, open: &mut [bool], labels: &[u32]) -> Vec<usize> {
        open[first] = false;
        let mut group = vec![first];
        let mut next = 0;
        while next < group.len() {
            for near in self.touching(group[next]) {
                if open[near] && labels[near] == labels[first] {
                    open[near] = false;
                    group.push(near);
                }
            }
            next += 1;
        }
        group
    }

    fn touching(&self, at: usize) -> Vec<usize> {
        neighbours(at, self.image.width(), self.image.height(), self.settings.connectivity.neighbours())
    }

    /// Whether a pixel rises above what is around it at four pixels.
    fn is_peak(&self, at: usize) -> bool {
        let (centre, v) = (self.place(at), self.image.values()[at]);
        let around = around(self.image, centre, (centre.0 + 4.0, centre.1));
        self.judge.exceeds(v - around, 3.0 * self.noise * grown(self.photon, v))
    }

    /// Makes a group a region, if two sources do not explain it.
    fn divide(&self, group: &[usize], regions: &mut Regions) {
        let label = regions.labels[group[0]];
        let Some(host) = regions.of(label).cloned() else { return };
        let mut beside = 0;
        for other in group.iter().flat_map(|&at| self.touching(at)).map(|near| regions.labels[near]) {
            if other != label && regions.sum(other) > regions.sum(beside) {
                beside = other;
            }
        }
        let divided = host.divided.map_or(0, |part| regions.labels[part]);
        let second = if beside != 0 { beside } else { divided };
        let explained = |at: usize| {
            let own = self.most_host_light(&host, at).unwrap_or(0.0);
            let Some(second_region) = regions.of(second).filter(|_| second != label) else { return own };
            let shown = nearest(self.image, opposite(second_region.centre, self.place(at)));
            if beside == 0 && shown.is_none_or(|shown| regions.labels[shown] != second) {
                return own;
            }
            own + alone(self.image, [host.centre, second_region.centre], self.place(at)).unwrap_or(0.0)
        };
        let may_be_knot = host.area > 50 && group.len() < 16;
        let is_of_host = |at: usize| {
            let opposite = mirrored(self.image, host.centre, self.place(at)).unwrap_or(0.0);
            may_be_knot && !self.judge.exceeds(self.image.values()[at], 3.5 * opposite)
        };
        let unexplained = group.iter().filter(|&&at| self.exceeds(at, explained(at)) && !is_of_host(at)).count();
        let excess =
            |at: usize| self.image.values()[at] - mirrored(self.image, host.centre, self.place(at)).unwrap_or(0.0);
        let peak = group.iter().copied().reduce(|best, at| if excess(at) > excess(best) { at } else { best });
        let peak = peak.unwrap_or(group[0]);
        let is_greatest = |at: usize, of: &dyn Fn(usize) -> f64| {
            neighbours(at, self.image.width(), self.image.height(), 8)
                .into_iter()
                .all(|near| !self.judge.exceeds(of(near), of(at)))
        };
        let has_maximum =
            || is_greatest(peak, &excess) || group.iter().any(|&at| is_greatest(at, &|at| self.image.values()[at]));
        if unexplained < self.settings.reopened_area || !self.is_peak(peak) || !has_maximum() {
            return;
        }
        regions.table[label as usize - 1].divide(self.image, peak);
        regions.table.push(Region {
            peak,
            value: excess(peak),
            area: group.len(),
            sum: group.iter().map(|&at| excess(at)).sum(),
            centre: self.place(peak),
            plateau: false,
            divided: Some(host.peak),
        });
        for &at in group {
            regions.labels[at] = regions.table.len() as u32;
        }
    }
}
