//! Six kinds of pairs, in most of which a plain formula for the time of impact loses digits.

use glam::DVec2;

use crate::detect::impact::Relative;
use crate::report::figures::random::Random;

/// Seed of the pairs.
pub const SEED: u64 = 1;

/// One kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// A few radii apart.
    Generic,
    /// 1e4 to 1e6 radii apart.
    Far,
    /// A gap of 1e-9 to 1e-13 of the reach.
    Near,
    /// Hit or miss by 1e-6 to 1e-12 of the reach.
    Grazing,
    /// Both far and grazing.
    FarGrazing,
    /// They overlap already.
    Overlapping,
}

impl Category {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Generic, Self::Far, Self::Near, Self::Grazing, Self::FarGrazing, Self::Overlapping];

    /// What they are.
    pub fn name(self) -> &'static str {
        match self {
            Self::Generic => "generic",
            Self::Far => "far",
            Self::Near => "gap 1e-9..1e-13",
            Self::Grazing => "grazing",
            Self::FarGrazing => "far and grazing",
            Self::Overlapping => "overlapping",
        }
    }

    /// So many of them.
    pub fn pairs(self, count: usize) -> Vec<Relative> {
        let mut random = Random::new(SEED + self as u64);
        (0..count).map(|_| self.pair(&mut random)).collect()
    }

    /// Position and velocity of the second seen from the first, sum of radii.
    fn pair(self, random: &mut Random) -> Relative {
        let s = random.uniform(0.1, 2.0);
        let normal = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
        let distance = match self {
            Self::Far | Self::FarGrazing => s * random.decades(4.0, 6.0),
            Self::Near => s * (1.0 + random.decades(-13.0, -9.0)),
            Self::Overlapping => s * random.uniform(0.5, 1.0),
            Self::Generic | Self::Grazing => s * random.uniform(1.0, 10.0),
        };
        let sine = match self {
            Self::Grazing | Self::FarGrazing => 1.0 + random.sign() * random.decades(-12.0, -6.0),
            _ => random.uniform(-1.2, 1.2),
        };
        let sine = (s / distance * sine).clamp(-1.0, 1.0);
        let along = normal.perp() * sine - normal * (1.0 - sine * sine).sqrt();
        Relative { d: normal * distance, w: along * random.uniform(0.1, 3.0), s }
    }
}
