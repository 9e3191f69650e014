//! Semidefinite cones against the second-order ones that stand in for them: the restriction to scaled
//! diagonal dominance may cost little of the margin.

use twinhub_design::certificate::Plan;
use twinhub_design::family::FactorBox;
use twinhub_design::gains::gains;
use twinhub_design::loops::Rider;
use twinhub_design::plan::family;
use twinhub_design::program::Cones;
use twinhub_design::proof::Bicycles;
use twinhub_design::start::from_scratch;
use twinhub_plant::bicycles::load_multibody;

/// Far beyond what can be reached, so that both climb to their best.
const GOAL_PER_S: f64 = 3.0;

fn plan() -> Plan {
    Plan {
        bicycle: "bulsink2017_bicycle1_full".to_owned(),
        joints_free: false,
        riders: vec![],
        uncertainty: FactorBox {
            mass: [0.9, 1.1],
            load: [0.9, 1.1],
            twisting: [0.5, 2.0],
        },
        speeds_m_s: vec![],
        torque_max_nm: 0.0,
        half_width_nm: 0.0,
        rate_m_s2: 0.0,
        slope_nm_per_m_s: 0.0,
        loss_growth_per_s: 0.0,
        friction_ratio: 0.6,
        cones: Cones::Semidefinite,
    }
}

#[test]
fn second_order_cones_lose_little_of_the_margin() {
    let plan = plan();
    plan.cones.check().expect("built with them");
    let young = Rider {
        name: "young".to_owned(),
        delay_s: 0.12,
        lag_rad_s: 30.0,
        lag_damping_ratio: 0.707,
    };
    let parameters = load_multibody(&plan.bicycle, &[] as &[&str]).expect("ships");
    let family = family(&plan, &parameters);
    let boxes = plan.uncertainty.split([2, 2, 6]);
    // The largest twisting torque of a light and of a heavy rider, the hardest boxes, at 7 m/s.
    for index in [5, 23] {
        let bicycles = Bicycles::new(&family, &boxes[index]).expect("a bicycle");
        let vehicles = bicycles.at(7.0, [0.0, 5.0]).expect("steady riding");
        let (k, _) = gains(&young, &vehicles, None);
        let closed = young.close_all(&vehicles, &k);
        let margin = |cones| {
            let found = from_scratch(cones, &closed, GOAL_PER_S).expect("a program");
            found.margin_per_s
        };
        let (dominant, semidefinite) = (margin(Cones::Dominant), margin(Cones::Semidefinite));
        println!(
            "box {index}: {dominant:.3} 1/s by second-order cones, {semidefinite:.3} by semidefinite ones"
        );
        assert!(dominant > 0.0, "box {index}: {dominant}");
        assert!(
            dominant > 0.85 * semidefinite,
            "box {index}: {dominant} 1/s, semidefinite {semidefinite}"
        );
        assert!(
            semidefinite > 0.85 * dominant,
            "box {index}: {semidefinite} 1/s, dominant {dominant}"
        );
    }
}
