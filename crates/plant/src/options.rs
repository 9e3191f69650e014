//! Options of the multibody model that are not entries of a registry of their own: what `twinhub
//! list options` shows, and where in TOML each is set.

use crate::explain::Explain;
use crate::multibody::PEDALLING;

/// Every option.
pub const OPTIONS: &[Explain] = &[
    Explain {
        name: "joints",
        what: "14 degrees of freedom: rear frame 6, steer, two wheel spins, trunk 3, each leg about its hip-ankle line; any joint locks (joints.NAME.free in the plant file), with spring, damper and preload",
        equation: "joint torque = preload - k q - c q'; a locked joint has no row in the equations of motion",
        source: "Bulsink (2017), section 3.2.1 and table A.1; Featherstone (2008), Rigid Body Dynamics Algorithms",
        assumes: "rigid bodies, frictionless joints; a leg is one body about its hip-ankle line",
    },
    Explain {
        name: "arms",
        what: "arms as linear spring-dampers between shoulder and grip, or as torsional ones about the steer axis (arms.* in the plant file; option arms=linear|torsional of the sets); arms.torque_on_trunk says who reacts the steer torque",
        equation: "linear: pull k (l - l0) + c l' along the arm; torsional: -k δ - c δ'",
        source: "Bulsink (2017), section 3.2.1 and table A.1 (525 N/m, 100 N s/m; 5 Nm/rad, 0.9 Nm s/rad)",
        assumes: "massless arms that pull and push; free of force at rest",
    },
    Explain {
        name: "forearms_on_front",
        what: "forearms and hands as part of the front assembly instead of the trunk (rider.forearms_on_front in the plant file)",
        equation: "one rigid body: masses, centres and tensors of fork and forearms added about one point",
        source: "Bulsink (2017), table 3.3 (case 3) and table A.1 (fork with arms)",
        assumes: "forearms turn with the bar as a rigid body",
    },
    PEDALLING,
    Explain {
        name: "rider_body",
        what: "the rider's bodies from height and mass (options rider_height_m and rider_mass_kg of the sets), the pelvis counted once",
        equation: "segment masses and moments of inertia linear in body mass; lengths as fractions of height; all scaled together to the given mass",
        source: "Bulsink (2017), appendix A.3 and A.3.1; lengths Winter (2009), Biomechanics and Motor Control of Human Movement, figure 4.1; posture a guess where the source is silent. An 80 kg rider of 1.80 m has 8.03, 8.75, 2.84 kg m² where table A.1 prints 10.47, 10.91, 2.17: no seated posture of these segments reaches the printed zz, so locked riders take the printed tensor",
        assumes: "adults of 1.4 to 2.1 m and 40 to 120 kg; posture fixed",
    },
    Explain {
        name: "relaxation_length_m",
        what: "side slip and longitudinal slip that build up over a distance (tyre.front.relaxation_length_m, tyre.rear.relaxation_length_m; absent: at once)",
        equation: "σ dα/dt = v_y - |v_x| α, and the same for longitudinal slip",
        source: "Pacejka (2006), Tyre and Vehicle Dynamics, section 7.2.1",
        assumes: "one length for all loads; camber acts at once",
    },
    Explain {
        name: "combined",
        what: "how longitudinal slip takes away side force: none, or an ellipse (tyre.front.combined, tyre.rear.combined)",
        equation: "ellipse: side force times √(1 - (F_x / (μ N))²)",
        source: "the friction ellipse of textbooks (Pacejka 2006, section 1.3.2); Bulsink (2017), appendix A.2, has none",
        assumes: "directions of the pure slips are kept",
    },
    Explain {
        name: "friction",
        what: "how the road's friction acts on the tyre's own (tyre.front.friction, tyre.rear.friction)",
        equation: "as_file: μ = μ_tyre μ_road; absolute: μ = μ_road, stiffnesses unaffected",
        source: "Bulsink (2017), appendix A.2 (tyre file 1.642) and section 3.2.1 (road 1.0)",
        assumes: "one coefficient for a spot of road",
    },
    Explain {
        name: "road",
        what: "slope, bank, bumps, and friction with patches, also on one side only (road.* of scenarios and courses)",
        equation: "height = x tan(slope) - y tan(bank) + Σ bumps(x); friction is that of the last patch that covers the spot, blended over its edge",
        source: "elementary; bumps: `twinhub explain cosine`, `step`, `roughness`",
        assumes: "plane over the contact patch; slope and bank up to 0.35 rad",
    },
    Explain {
        name: "wind",
        what: "steady wind and gusts (wind.* of scenarios and courses) on the drag areas of the plant file (air.*)",
        equation: "F = ½ ρ A |v| v along each axis of the frame, v the air's velocity past the centre of pressure",
        source: "drag areas: Wilson and Schmidt (2020), Bicycling Science, 4th ed., about 0.55 m² upright",
        assumes: "one point of attack; no lift",
    },
    Explain {
        name: "watchdog",
        what: "each motor drive's own watch over its commands (in every motor set)",
        equation: "after 20 ms without a command the torque ramps to zero",
        source: "own design; a dead controller cannot ramp",
        assumes: "the drive's own clock is right; scenarios show it with commands_end_s",
    },
    Explain {
        name: "linearisation",
        what: "the model linearised about any steady state: straight, steady turn (--roll-deg of `twinhub modes`), accelerating (--rear-torque-nm), at any torque pair",
        equation: "x' = A x + B u by dual numbers about the state where the derivative is a·w; eigenvalues followed over speed and named by shape",
        source: "Griewank and Walther (2008), Evaluating Derivatives, chapter 3; Bulsink (2017), section 3.2.3 (weave and capsize speed)",
        assumes: "small disturbances; an accelerating state is steady only while speed hardly changes",
    },
    Explain {
        name: "sensitivities",
        what: "derivatives of weave eigenvalue and weave speed with respect to every parameter (--sensitivities of `twinhub modes`)",
        equation: "dλ/dp = wᴴ (dA/dp) v / (wᴴ v); weave speed moves by -Re(dλ/dp) / Re(dλ/dv)",
        source: "Lancaster (1964), Numerische Mathematik 6",
        assumes: "a simple eigenvalue; dA/dp by central differences of exact state matrices",
    },
    Explain {
        name: "interaction",
        what: "forces between rider and bicycle as columns of `twinhub simulate`: sum about the saddle, arms, pedals",
        equation: "force on the bicycle = m g - dp/dt of the rider's bodies; the moment likewise about the saddle",
        source: "Bulsink (2017), chapter 5; own formulation",
        assumes: "saddle and bar share the sum only as far as springs and pedals say",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_explained_in_full_and_named_once() {
        for (k, option) in OPTIONS.iter().enumerate() {
            assert!(option.is_complete(), "{}", option.name);
            assert!(
                OPTIONS[..k].iter().all(|o| o.name != option.name),
                "{}",
                option.name
            );
        }
        for (about, bump) in crate::road::BUMPS {
            assert!(bump.explain().is_complete() && about.len() > 5);
            assert_eq!(bump.explain().name, bump.name());
            bump.validate().unwrap();
        }
        for (about, gust) in crate::wind::GUSTS {
            assert!(gust.explain().is_complete() && about.len() > 5);
            assert_eq!(gust.explain().name, gust.name());
            gust.validate().unwrap();
        }
    }

    use crate::road::BumpModel as _;
    use crate::wind::GustModel as _;
}
