//! Connected components: pictures drawn as text, and a plain flood fill for what is not drawn.

use skyfront_core::config::Connectivity::{self, Eight, Four};
use skyfront_tests::text::{label, mask, picture};

fn labelled(lines: &[&str], connectivity: Connectivity, min_area: u32) -> Vec<String> {
    let (front, width) = mask(lines);
    picture(&label(&front, width, connectivity, min_area), width)
}

#[test]
fn corners_join_only_with_eight_neighbours() {
    let lines = ["#..#", ".##.", "....", "#.#."];
    assert_eq!(labelled(&lines, Four, 1), ["4..5", ".33.", "....", "1.2."]);
    assert_eq!(labelled(&lines, Eight, 1), ["3..3", ".33.", "....", "1.2."]);
}

#[test]
fn a_spiral_is_one_component_and_labels_follow_first_pixels() {
    let lines = ["#######", "#.....#", "#.###.#", "#.#.#.#", "#.#...#", "#.#####", "#......"];
    let expected = ["1111111", "1.....1", "1.111.1", "1.1.1.1", "1.1...1", "1.11111", "1......"];
    assert_eq!(labelled(&lines, Four, 1), expected);
}

#[test]
fn small_components_are_dropped_and_the_rest_renumbered() {
    let lines = ["##..#", "##...", "....#", "#..##"];
    assert_eq!(labelled(&lines, Four, 1), ["33..4", "33...", "....2", "1..22"]);
    assert_eq!(labelled(&lines, Four, 2), ["22...", "22...", "....1", "...11"]);
    assert_eq!(labelled(&lines, Four, 4), ["11...", "11...", ".....", "....."]);
}

/// A flood fill with a stack, row-major, labels in raster order of first pixels.
fn flood(front: &[f32], width: usize, connectivity: Connectivity) -> Vec<u32> {
    let (mut labels, mut count) = (vec![0; front.len()], 0);
    for start in 0..front.len() {
        if front[start] <= 0.0 || labels[start] != 0 {
            continue;
        }
        count += 1;
        let mut stack = vec![start];
        while let Some(pixel) = stack.pop() {
            if front[pixel] <= 0.0 || labels[pixel] != 0 {
                continue;
            }
            labels[pixel] = count;
            let (x, y) = ((pixel % width) as isize, (pixel / width) as isize);
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let diagonal = dx != 0 && dy != 0;
                let (x, y) = (x + dx, y + dy);
                let inside = x >= 0 && x < width as isize && y >= 0 && y < (front.len() / width) as isize;
                if inside && !(diagonal && connectivity == Four) {
                    stack.push(y as usize * width + x as usize);
                }
            }
        }
    }
    labels
}

#[test]
fn random_masks_agree_with_a_flood_fill() {
    let mut seed = 1u32;
    for case in 0..300 {
        let (width, height) = (2 + case % 17, 2 + case % 13);
        let front: Vec<f32> = (0..width * height)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if seed >> 30 == 0 { -1.0 } else { ((seed >> 29) & 1) as f32 - 0.5 }
            })
            .collect();
        for connectivity in [Four, Eight] {
            let (ours, plain) = (label(&front, width, connectivity, 1), flood(&front, width, connectivity));
            assert_eq!(picture(&ours, width), picture(&plain, width), "case {case}, {connectivity:?}");
        }
    }
}
