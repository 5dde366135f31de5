//! The judge of [`super::pair`]: the vector method, step by step as it is taught.
//!
//! C. Berchek, "2-Dimensional Elastic Collisions without Trigonometry" (2009), with restitution in
//! step 5. Every term has the size of the velocities, so digits are lost where masses or speeds
//! differ much and an infinite mass gives NaN: it judges, it does not run.

use glam::DVec2;

use crate::world::Disc;

/// New velocities of two touching discs with different centres.
pub fn collide(a: &Disc, b: &Disc, restitution: f64) -> (DVec2, DVec2) {
    // 1. Unit normal and unit tangent.
    let n = b.position - a.position;
    let un = n / n.length();
    let ut = DVec2::new(-un.y, un.x);
    // 2. The velocities as vectors.
    let (v1, v2) = (a.velocity, b.velocity);
    // 3. Their parts along the normal and the tangent.
    let (v1n, v1t) = (un.dot(v1), ut.dot(v1));
    let (v2n, v2t) = (un.dot(v2), ut.dot(v2));
    // 4. The tangential parts stay. 5. Along the normal it is a one-dimensional collision.
    let (m1, m2, e) = (a.mass, b.mass, restitution);
    let v1n_after = (v1n * (m1 - e * m2) + (1.0 + e) * m2 * v2n) / (m1 + m2);
    let v2n_after = (v2n * (m2 - e * m1) + (1.0 + e) * m1 * v1n) / (m1 + m2);
    // 6. Back to vectors. 7. Their sums are the new velocities.
    (v1n_after * un + v1t * ut, v2n_after * un + v2t * ut)
}
