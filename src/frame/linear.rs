//! Light from grey values: the camera's response undone.

/// Light, 1 at full scale, of every grey value of a camera whose grey is light to the power of 1 / gamma.
#[derive(Debug, Clone)]
pub struct Linear {
    gamma: f64,
    /// Light of the 256 grey values of 8 bit.
    bytes: Box<[f32; 256]>,
    /// Light of the 65536 grey values of 16 bit; empty where they are light already.
    words: Vec<f32>,
}

impl Linear {
    /// Of a response of this gamma; `sixteen_bit` says which frames it is for.
    pub fn new(gamma: f64, sixteen_bit: bool) -> Self {
        let light = |unit: f64| {
            if gamma == 1.0 {
                unit as f32
            } else {
                unit.powf(gamma) as f32
            }
        };
        let words = if sixteen_bit && gamma != 1.0 {
            (0..=u16::MAX)
                .map(|v| light(f64::from(v) / 65535.0))
                .collect()
        } else {
            Vec::new()
        };
        Self {
            gamma,
            bytes: Box::new(std::array::from_fn(|v| light(v as f64 / 255.0))),
            words,
        }
    }

    /// The response's gamma.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Light of an 8-bit grey value.
    #[inline(always)]
    pub fn of_u8(&self, grey: u8) -> f32 {
        self.bytes[usize::from(grey)]
    }

    /// Light of a 16-bit grey value.
    #[inline(always)]
    pub fn of_u16(&self, grey: u16) -> f32 {
        let unit = f32::from(grey) * (1.0 / 65535.0);
        match self.words.get(usize::from(grey)) {
            Some(&light) => light,
            None if self.gamma == 1.0 => unit,
            None => unit.powf(self.gamma as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_stay_and_the_middle_bends() {
        for sixteen_bit in [false, true] {
            let linear = Linear::new(2.2, sixteen_bit);
            assert_eq!((linear.of_u8(0), linear.of_u8(255)), (0.0, 1.0));
            assert_eq!((linear.of_u16(0), linear.of_u16(u16::MAX)), (0.0, 1.0));
            let half = 0.5_f64.powf(2.2) as f32;
            assert!((linear.of_u16(32768) - half).abs() < 1e-4);
        }
        let plain = Linear::new(1.0, true);
        assert_eq!(plain.of_u8(51), 0.2);
        assert!((plain.of_u16(13107) - 0.2).abs() < 1e-7);
    }
}
