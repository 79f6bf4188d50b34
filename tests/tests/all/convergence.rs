//! Order of convergence of the schemes that move a front without curvature, measured and kept as a table in host/doc/front.md.
//!
//! A circle of radius 2 grows until t = 1, at speed 1 or at g = 1 / (1 + r/2). u0 is the time s(r) - s(2) at which the
//! front arrives from there, s(r) the integral of 1/g, so that u = s(r) - s(2) - t away from the middle. The mean error
//! over 1.5 <= r <= 3.5 is taken on four grids. f32 rounds u by 1e-7 a step, which shows
//! in the least of the errors only. To renew the table run this test with `CONVERGENCE=write`.

use skyfront::crosscheck::parameters;
use skyfront::reference::{Plane, step};
use skyfront_core::config::{Config, Scheme};
use skyfront_tests::evolve::Front;
use std::fmt::Write;
use std::ops::Range;

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../host/doc/front.md");
const BEGIN: &str = "<!-- convergence: made by tests/tests/all/convergence.rs -->\n";
const END: &str = "<!-- end of convergence -->";
const GRIDS: [usize; 4] = [51, 101, 201, 401];

/// A scheme, the coefficient a of the speed 1 / (1 + a r), and the order between two grids: the scheme's, but for the
/// next term of the expansion and for rounding.
struct Course {
    scheme: Scheme,
    slowing: f64,
    order: Range<f64>,
}

const COURSES: [Course; 5] = [
    Course { scheme: Scheme::Fd, slowing: 0.0, order: 0.75..1.3 },
    Course { scheme: Scheme::Sl, slowing: 0.0, order: 0.75..1.3 },
    Course { scheme: Scheme::FdFiltered, slowing: 0.0, order: 1.8..2.1 },
    Course { scheme: Scheme::Fd, slowing: 0.5, order: 0.75..1.3 },
    Course { scheme: Scheme::FdFiltered, slowing: 0.5, order: 1.8..2.1 },
];

impl Course {
    /// 64 directions: with 16 the semi-Lagrangian minimum misses a normal by up to 2 % on any grid.
    fn config(&self, n: usize) -> Config {
        Config { dx: 10.0 / (n as f32 - 1.0), directions: 64, ..Config::PAPER_F160 }.with_scheme(self.scheme)
    }

    /// The time from the circle of radius 2 to that of radius r.
    fn arrival(&self, r: f64) -> f64 {
        r - 2.0 + self.slowing / 2.0 * (r * r - 4.0)
    }

    fn speed(&self, r: f64) -> f64 {
        1.0 / (1.0 + self.slowing * r)
    }

    /// The mean |u - (s(r) - s(2) - 1)| at t = 1 over the band of radii.
    fn error(&self, front: impl Iterator<Item = f64>, n: usize) -> f64 {
        let errors = front.enumerate().filter_map(|(at, u)| {
            let r = radius(at, n);
            (1.5..=3.5).contains(&r).then(|| (u - (self.arrival(r) - 1.0)).abs())
        });
        let (count, sum) = errors.fold((0.0, 0.0), |(count, sum), error| (count + 1.0, sum + error));
        sum / count
    }

    /// The error of the core, on a grid of n x n nodes over 10 x 10 units of length.
    fn core(&self, n: usize) -> f64 {
        let mut front = Front::new(self.config(n), n, n, |x, y| self.arrival(x.hypot(y)));
        front.speed.iter_mut().enumerate().for_each(|(at, g)| *g = self.speed(radius(at, n)) as f32);
        front.until(1.0);
        self.error(front.values.iter().map(|&u| u.into()), n)
    }

    /// The error of the f64 reference.
    fn reference(&self, n: usize) -> f64 {
        let parameters = parameters(&self.config(n));
        let plane =
            |value: &dyn Fn(f64) -> f64| Plane::from_fn(n, n, |i, j| value(radius(j as usize * n + i as usize, n)));
        let (g, mut u) = (plane(&|r| self.speed(r)), plane(&|r| self.arrival(r)));
        for _ in 0..(1.0 / parameters.dt).round() as usize {
            u = step(&parameters, &g, &u);
        }
        self.error(u.values().iter().copied(), n)
    }
}

/// The distance of a node from the middle, in units of length.
fn radius(at: usize, n: usize) -> f64 {
    let middle = (n as f64 - 1.0) / 2.0;
    ((at % n) as f64 - middle).hypot((at / n) as f64 - middle) * 5.0 / middle
}

#[test]
fn every_scheme_converges_at_its_order() {
    let mut table = "| dx | FD | order | SL | order | filtered FD | order | FD, g | order | filtered FD, g | order |\n\
                     |---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    let mut before: Option<[f64; 5]> = None;
    for n in GRIDS {
        let errors = COURSES.each_ref().map(|course| course.core(n));
        write!(table, "| {} |", 10.0 / (n as f64 - 1.0)).expect("text takes every line");
        for (at, (course, error)) in COURSES.iter().zip(errors).enumerate() {
            let order = before.map(|before| (before[at] / error).log2());
            let text = order.map_or("".to_owned(), |order| format!("{order:.2}"));
            write!(table, " {error:.6} | {text} |").expect("text takes every line");
            let (scheme, expected) = (course.scheme, &course.order);
            assert!(order.is_none_or(|order| expected.contains(&order)), "{scheme:?}: order {order:?}\n{table}");
        }
        table.push('\n');
        before = Some(errors);
    }
    println!("{table}");
    let page = std::fs::read_to_string(PAGE).expect("host/doc/front.md");
    let (head, rest) = page.split_once(BEGIN).expect("the place of the table in host/doc/front.md");
    let (kept, tail) = rest.split_once(END).expect("the end of the table in host/doc/front.md");
    if std::env::var("CONVERGENCE").as_deref() == Ok("write") {
        std::fs::write(PAGE, format!("{head}{BEGIN}{table}{END}{tail}")).expect("the page can be written");
    } else {
        assert_eq!(kept, table, "the table in host/doc/front.md");
    }
}

/// f64 leaves rounding out: the errors of f32 are those of the scheme.
#[test]
fn the_reference_converges_at_the_same_order() {
    for course in COURSES.iter().filter(|course| course.scheme == Scheme::FdFiltered) {
        let errors = [51, 101, 201].map(|n| (course.reference(n), course.core(n)));
        println!("{errors:?}");
        for (reference, core) in errors {
            assert!((reference - core).abs() < 0.02 * reference, "{errors:?}");
        }
        for pair in errors.windows(2) {
            let order = (pair[0].0 / pair[1].0).log2();
            assert!((1.95..2.1).contains(&order), "order {order}");
        }
    }
}
