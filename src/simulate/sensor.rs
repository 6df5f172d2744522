//! Light to grey values: shot noise, read noise, clipping, response, quantisation.

use super::scene::{BitDepth, Sensor};
use crate::frame::{Frame, Plane};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Poisson, StandardNormal};
use rayon::prelude::*;

/// The frame that the sensor delivers; every row has its own stream of random numbers.
pub(super) fn expose(light: &Plane<f32>, sensor: &Sensor, seed: u64) -> Frame {
    let (width, height) = (light.width(), light.height());
    match sensor.depth {
        BitDepth::Eight => {
            let mut plane = Plane::filled(width, height, 0_u8);
            fill(plane.data_mut(), light, sensor, seed, |unit| {
                (unit * 255.0).round() as u8
            });
            Frame::from_u8(plane, "simulated")
        }
        BitDepth::Sixteen => {
            let mut plane = Plane::filled(width, height, 0_u16);
            fill(plane.data_mut(), light, sensor, seed, |unit| {
                (unit * 65535.0).round() as u16
            });
            Frame::from_u16(plane, "simulated")
        }
    }
}

/// Writes the grey values of all rows.
fn fill<T: Send>(
    grey: &mut [T],
    light: &Plane<f32>,
    sensor: &Sensor,
    seed: u64,
    quantise: impl Fn(f64) -> T + Sync,
) {
    let start = ChaCha8Rng::seed_from_u64(seed);
    let rows = grey.par_chunks_mut(light.width()).enumerate();
    rows.for_each(|(y, row)| {
        let mut random = start.clone();
        random.set_stream(y as u64);
        for (grey, light) in row.iter_mut().zip(light.row(y)) {
            let noisy = with_noise(f64::from(*light), sensor, &mut random);
            *grey = quantise(response(noisy, sensor.gamma));
        }
    });
}

/// Light as the sensor counts it.
fn with_noise(light: f64, sensor: &Sensor, random: &mut ChaCha8Rng) -> f64 {
    let mut light = light;
    if let Some(full_well) = sensor.full_well_electrons {
        // no electrons where the mean is 0, for which there is no Poisson distribution
        let counted = Poisson::new(light * full_well).map_or(0.0, |d| d.sample(random));
        light = counted / full_well;
    }
    if sensor.read_noise > 0.0 {
        let normal: f64 = StandardNormal.sample(random);
        light += sensor.read_noise * normal;
    }
    light
}

/// Grey value 0..1 of light, clipped at nothing and at full scale.
fn response(light: f64, gamma: f64) -> f64 {
    let clipped = light.clamp(0.0, 1.0);
    if gamma == 1.0 {
        clipped
    } else {
        clipped.powf(gamma.recip())
    }
}
