//! Error-free arithmetic against exact rationals.

use carom::exact::{
    DoubleDouble, RunningSum, power_of_two_near, sign_of_sum, sum_of_products, two_product,
};
use dashu_ratio::RBig;

use crate::common::Random;

fn rational(x: f64) -> RBig {
    RBig::try_from(x).expect("finite")
}

#[test]
fn sign_of_sum_is_exact() {
    let mut random = Random::new(1);
    for _ in 0..20_000 {
        let mut terms: Vec<f64> = (0..9).map(|_| random.wide(20.0)).collect();
        // Let the sum cancel to almost or exactly nothing.
        let negated: Vec<f64> = terms.iter().map(|t| -t).collect();
        terms.extend(negated);
        let k = random.below(terms.len());
        if random.below(3) > 0 {
            terms[k] = f64::from_bits(terms[k].to_bits() + 1);
        }
        random.shuffle(&mut terms);
        let sum = terms.iter().fold(RBig::ZERO, |sum, &t| sum + rational(t));
        let expected = if sum.is_zero() {
            0
        } else if sum > RBig::ZERO {
            1
        } else {
            -1
        };
        assert_eq!(sign_of_sum(&mut terms), expected);
    }
}

#[test]
fn sums_and_products_keep_what_they_round() {
    let mut random = Random::new(2);
    for _ in 0..20_000 {
        let [a, b, c, d] = [(); 4].map(|()| random.wide(30.0));
        let (product, error) = two_product(a, b);
        assert_eq!(rational(product) + rational(error), rational(a) * rational(b));
        let sum = DoubleDouble::sum(a, b);
        assert_eq!(rational(sum.hi) + rational(sum.lo), rational(a) + rational(b));
        let exact = rational(a) * rational(b) + rational(c) * rational(d);
        let computed = sum_of_products(a, b, c, d);
        let error = (rational(computed) - &exact).to_f64().value().abs();
        assert!(error <= 1.6 * f64::EPSILON * exact.to_f64().value().abs());
    }
}

#[test]
fn running_sum_survives_cancellation() {
    let sum: RunningSum = [1e16, 1.0, 1.0, -1e16].into_iter().collect();
    assert_eq!(sum.value(), 2.0);
}

#[test]
fn powers_of_two_are_near_and_in_range() {
    for x in [1.0, 0.75, 3.0, 1e-310, 5e-324, 1e308, f64::MIN_POSITIVE, 2.5e-290] {
        let unit = power_of_two_near(x);
        assert_eq!(unit.to_bits() & ((1 << 52) - 1), 0, "a power of two");
        if (1e-300..1e300).contains(&x) {
            assert!((1.0..2.0).contains(&(x / unit)));
        }
        assert!((1.0 / unit).is_finite() && unit > 0.0);
    }
    assert_eq!(power_of_two_near(0.0), 1.0);
    assert_eq!(power_of_two_near(f64::INFINITY), 1.0);
}
