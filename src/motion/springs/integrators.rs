//! Explicit integrators for stiff springs, to compare with, and the longest step that each stands.
//!
//! Undamped, a step of length `h` is stable up to `h omega = 2` (semi-implicit Euler, Verlet),
//! `sqrt 3` (RK3), `2 sqrt 2` (RK4), and never (forward Euler, RK2). With damping the limit is
//! found from the spectral radius of one step.
//!
//! Nothing here knows what pushes: the acceleration is an argument.

use glam::DVec2;

/// An explicit integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Explicit {
    /// Positions and velocities from the old state; gains energy at any step.
    ForwardEuler,
    /// Velocities first, positions with the new ones; first order, symplectic.
    SemiImplicitEuler,
    /// Half a kick, drift, half a kick; second order, symplectic.
    VelocityVerlet,
    /// The midpoint rule; second order.
    Rk2,
    /// Kutta's rule of third order.
    Rk3,
    /// The classical rule of fourth order.
    Rk4,
}

/// Positions and velocities of all bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// m.
    pub positions: Vec<DVec2>,
    /// m/s.
    pub velocities: Vec<DVec2>,
}

impl State {
    /// `self + h * rate`, where the rate of the positions are velocities.
    fn plus(&self, h: f64, velocities: &[DVec2], accelerations: &[DVec2]) -> Self {
        let add = |a: &[DVec2], b: &[DVec2]| a.iter().zip(b).map(|(a, b)| *a + h * *b).collect();
        Self {
            positions: add(&self.positions, velocities),
            velocities: add(&self.velocities, accelerations),
        }
    }
}

/// A Runge-Kutta rule: the stages' weights of the stages before, and the weights of the sum.
type Tableau = (&'static [&'static [f64]], &'static [f64]);

impl Explicit {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::ForwardEuler,
        Self::SemiImplicitEuler,
        Self::VelocityVerlet,
        Self::Rk2,
        Self::Rk3,
        Self::Rk4,
    ];

    /// Its name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::ForwardEuler => "forward Euler",
            Self::SemiImplicitEuler => "semi-implicit Euler",
            Self::VelocityVerlet => "velocity Verlet",
            Self::Rk2 => "RK2",
            Self::Rk3 => "RK3",
            Self::Rk4 => "RK4",
        }
    }

    /// One step of length `h` (s); `acceleration` gives m/s^2 for a state.
    ///
    /// # Errors
    /// That of `acceleration`.
    pub fn step<E>(
        self,
        state: &State,
        h: f64,
        mut acceleration: impl FnMut(&State) -> Result<Vec<DVec2>, E>,
    ) -> Result<State, E> {
        let kick = |state: &State, h: f64, acceleration: &[DVec2]| {
            let still = vec![DVec2::ZERO; state.positions.len()];
            state.plus(h, &still, acceleration)
        };
        let drift = |state: &State| {
            let none = vec![DVec2::ZERO; state.positions.len()];
            state.plus(h, &state.velocities, &none)
        };
        match self {
            Self::SemiImplicitEuler => Ok(drift(&kick(state, h, &acceleration(state)?))),
            Self::VelocityVerlet => {
                let there = drift(&kick(state, 0.5 * h, &acceleration(state)?));
                let last = acceleration(&there)?;
                Ok(kick(&there, 0.5 * h, &last))
            }
            _ => runge_kutta(self.tableau(), state, h, acceleration),
        }
    }

    fn tableau(self) -> Tableau {
        match self {
            Self::Rk2 => (&[&[], &[0.5]], &[0.0, 1.0]),
            Self::Rk3 => (&[&[], &[0.5], &[-1.0, 2.0]], &[1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0]),
            Self::Rk4 => (
                &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
                &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
            ),
            _ => (&[&[]], &[1.0]),
        }
    }

    /// The longest stable step (s) for a contact with these `omega0` and `beta` (1/s); 0 = none.
    pub fn largest_stable_step(self, omega0: f64, beta: f64) -> f64 {
        let damping = beta / omega0;
        if damping == 0.0 {
            let limit = match self {
                Self::ForwardEuler | Self::Rk2 => 0.0,
                Self::SemiImplicitEuler | Self::VelocityVerlet => 2.0,
                Self::Rk3 => 3.0f64.sqrt(),
                Self::Rk4 => 8.0f64.sqrt(),
            };
            return limit / omega0;
        }
        // Beyond 4 no explicit rule is stable; the stable steps are an interval from 0.
        let (mut stable, mut unstable) = (0.0, 4.0);
        for _ in 0..80 {
            let middle = 0.5 * (stable + unstable);
            let holds = self.growth(middle, damping) <= 1.0 + 1e-13;
            *(if holds { &mut stable } else { &mut unstable }) = middle;
        }
        stable / omega0
    }

    /// Spectral radius of one step of `x'' = -2 zeta x' - x`.
    fn growth(self, h: f64, zeta: f64) -> f64 {
        let column = |x: f64, v: f64| {
            let state =
                State { positions: vec![DVec2::new(x, 0.0)], velocities: vec![DVec2::new(v, 0.0)] };
            let spring = |s: &State| -> Result<Vec<DVec2>, std::convert::Infallible> {
                Ok(vec![-s.positions[0] - 2.0 * zeta * s.velocities[0]])
            };
            let Ok(after) = self.step(&state, h, spring);
            [after.positions[0].x, after.velocities[0].x]
        };
        spectral_radius(column(1.0, 0.0), column(0.0, 1.0))
    }
}

/// Largest size of an eigenvalue of the matrix with these two columns.
pub fn spectral_radius(first: [f64; 2], second: [f64; 2]) -> f64 {
    let half_trace = 0.5 * (first[0] + second[1]);
    let determinant = first[0] * second[1] - first[1] * second[0];
    // (trace / 2)^2 - determinant without its cancellation.
    let half_difference = 0.5 * (first[0] - second[1]);
    let discriminant = half_difference * half_difference + first[1] * second[0];
    if discriminant < 0.0 {
        return determinant.sqrt();
    }
    half_trace.abs() + discriminant.sqrt()
}

fn runge_kutta<E>(
    (stages, weights): Tableau,
    state: &State,
    h: f64,
    mut acceleration: impl FnMut(&State) -> Result<Vec<DVec2>, E>,
) -> Result<State, E> {
    let mut slopes: Vec<(Vec<DVec2>, Vec<DVec2>)> = Vec::with_capacity(stages.len());
    let sum = |weights: &[f64], slopes: &[(Vec<DVec2>, Vec<DVec2>)]| {
        let used = weights.iter().zip(slopes).filter(|(weight, _)| **weight != 0.0);
        used.fold(state.clone(), |sum, (weight, (v, a))| sum.plus(h * weight, v, a))
    };
    for stage in stages {
        let at = sum(stage, &slopes);
        let slope = acceleration(&at)?;
        slopes.push((at.velocities, slope));
    }
    Ok(sum(weights, &slopes))
}
