// MuJoCo's step on our bicycle, behind a C interface. Contact and tyres are ours, in a callback, so
// that both sides ride on the same physics: the geometry of `multibody/contact.rs` and the Magic
// Formula of `tyre/magic_formula.rs`, motorcycle form, road friction 1, no combined slip.

#include <math.h>
#include <mujoco/mujoco.h>
#include <stddef.h>
#include <string.h>

// Order as in `mujoco.rs`.
typedef struct {
    double nominal_load, shape_x, mu_x, stiffness_x, shape_alpha, shape_gamma, mu_y, mu_y_load;
    double cornering_max, cornering_peak, camber, camber_load, trail_slope, trail_slope_load;
    double trail_shape, trail_peak, trail_peak_load, twisting, twisting_load, rolling, overturning;
    double spring, damper, radius, speed_floor;
} Tyre;

typedef struct {
    int body, parent, joint, dof;
    Tyre tyre;
} Wheel;

static Wheel wheels[2];

static void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double limited(double v, double low, double high) {
    return v < low ? low : v > high ? high : v;
}

// sin and cos of C atan(u).
static void shape(double c, double u, double *sine, double *cosine) {
    if (c == 1.0) {
        *cosine = 1.0 / sqrt(1.0 + u * u);
        *sine = u * *cosine;
    } else {
        const double angle = c * atan(u);
        *sine = sin(angle);
        *cosine = cos(angle);
    }
}

typedef struct {
    double along, side, overturning, rolling, aligning;
} Forces;

static Forces magic_formula(const Tyre *t, double fz, double kappa, double alpha, double gamma,
                            double speed) {
    const double fz0 = t->nominal_load, r = t->radius, df = fz / fz0 - 1.0;
    const double mu_y = t->mu_y * exp(t->mu_y_load * df);
    double sine, cosine, sa, ca, sg, cg, bell;
    shape(t->shape_x, kappa * t->stiffness_x / (t->shape_x * t->mu_x), &sine, &cosine);
    const double along = t->mu_x * fz * sine;
    const double peak = t->cornering_peak * fz0;
    const double u =
        alpha * t->cornering_max * fz0 / t->shape_alpha / (sqrt(fz * fz + peak * peak) * mu_y);
    const double w = -gamma * (t->camber + t->camber_load * df) / t->shape_gamma / mu_y;
    const double dy = mu_y * fz;
    shape(t->shape_alpha, u, &sa, &ca);
    shape(t->shape_gamma, w, &sg, &cg);
    shape(t->trail_shape, (t->trail_slope + t->trail_slope_load * df) * alpha, &sine, &bell);
    const double trail =
        fz * (t->trail_peak + t->trail_peak_load * df) * r / fz0 * bell * cos(alpha);
    const double way = limited(speed / 0.02, -1.0, 1.0);
    Forces f;
    f.along = along;
    f.side = dy * (sa * cg + ca * sg);
    f.overturning = -fz * gamma * r * t->overturning;
    f.rolling = fz * r * t->rolling * way * (1.5 - 0.5 * way * way);
    f.aligning = limited(-fz * gamma * r * (t->twisting + t->twisting_load * df) - trail * dy * sa,
                         -0.05 * fz, 0.05 * fz);
    return f;
}

static void tyre(const mjModel *m, mjData *d, const Wheel *wheel) {
    const Tyre *t = &wheel->tyre;
    const double *hub = d->xpos + 3 * wheel->body;
    const double *back = d->xaxis + 3 * wheel->joint; // to the left: rolling forward is positive
    const double axle[3] = {-back[0], -back[1], -back[2]};
    const double down[3] = {0, 0, 1};
    const double sin_camber = axle[2], inverse_cos = 1.0 / sqrt(1.0 - sin_camber * sin_camber);
    double forward[3], right[3], radial[3], arm[3], from[3], turn[3], velocity[6];
    cross(axle, down, forward);
    for (int k = 0; k < 3; ++k) {
        forward[k] *= inverse_cos;
        radial[k] = (down[k] - axle[k] * sin_camber) * inverse_cos;
    }
    cross(down, forward, right);
    const double loaded = -hub[2] * inverse_cos;
    const double *base = d->xpos + 3 * wheel->parent;
    for (int k = 0; k < 3; ++k) {
        arm[k] = loaded * radial[k];
        from[k] = hub[k] + arm[k] - base[k];
    }
    mj_objectVelocity(m, d, mjOBJ_XBODY, wheel->parent, velocity, 0);
    cross(velocity, from, turn);
    for (int k = 0; k < 3; ++k) velocity[3 + k] += turn[k];
    const double speed = dot(velocity + 3, forward), slide = dot(velocity + 3, right);
    const double sink = dot(velocity + 3, down), deflection = t->radius - loaded;
    double load = fmin(deflection, 0.1) * t->spring * inverse_cos + sink * t->damper;
    load = deflection > 0 ? limited(load, 0.0, 8000.0) : 0.0;
    const double reference = sqrt(speed * speed + t->speed_floor * t->speed_floor);
    const double kappa = (d->qvel[wheel->dof] * loaded - speed) / reference;
    const Forces f = magic_formula(t, load, kappa, atan(slide / reference),
                                   atan(sin_camber * inverse_cos), speed);
    double *wrench = d->xfrc_applied + 6 * wheel->body;
    for (int k = 0; k < 3; ++k)
        wrench[k] = forward[k] * f.along + right[k] * f.side - down[k] * load;
    cross(arm, wrench, wrench + 3);
    for (int k = 0; k < 3; ++k)
        wrench[3 + k] += down[k] * f.aligning + forward[k] * f.overturning + axle[k] * f.rolling;
}

static void control(const mjModel *m, mjData *d) {
    tyre(m, d, &wheels[0]);
    tyre(m, d, &wheels[1]);
}

typedef struct {
    mjModel *model;
    mjData *data;
} Peer;

static Peer peer;

// A model from MJCF and two tyres (rear, front); null and a message where that fails.
void *mujoco_build(const char *xml, const Tyre *tyres, char *error, int size) {
    mjSpec *spec = mj_parseXMLString(xml, NULL, error, size);
    if (!spec) return NULL;
    peer.model = mj_compile(spec, NULL);
    if (!peer.model) {
        strncpy(error, mjs_getError(spec), size - 1);
        return NULL;
    }
    mj_deleteSpec(spec);
    peer.data = mj_makeData(peer.model);
    const char *names[2] = {"rear_wheel", "front_wheel"};
    for (int k = 0; k < 2; ++k) {
        Wheel *wheel = &wheels[k];
        wheel->body = mj_name2id(peer.model, mjOBJ_BODY, names[k]);
        wheel->joint = mj_name2id(peer.model, mjOBJ_JOINT, names[k]);
        wheel->parent = peer.model->body_parentid[wheel->body];
        wheel->dof = peer.model->jnt_dofadr[wheel->joint];
        wheel->tyre = tyres[k];
    }
    mjcb_control = control;
    return &peer;
}

int mujoco_positions(const void *p) { return ((const Peer *)p)->model->nq; }
int mujoco_velocities(const void *p) { return ((const Peer *)p)->model->nv; }

void mujoco_state(void *p, const double *q, const double *v, const double *force) {
    const Peer *s = p;
    memcpy(s->data->qpos, q, sizeof(double) * s->model->nq);
    memcpy(s->data->qvel, v, sizeof(double) * s->model->nv);
    memcpy(s->data->qfrc_applied, force, sizeof(double) * s->model->nv);
}

void mujoco_read(const void *p, double *q, double *v, double *acceleration) {
    const Peer *s = p;
    memcpy(q, s->data->qpos, sizeof(double) * s->model->nq);
    memcpy(v, s->data->qvel, sizeof(double) * s->model->nv);
    memcpy(acceleration, s->data->qacc, sizeof(double) * s->model->nv);
}

void mujoco_forward(void *p, long count) {
    const Peer *s = p;
    for (long k = 0; k < count; ++k) mj_forward(s->model, s->data);
}

void mujoco_step(void *p, long count) {
    const Peer *s = p;
    for (long k = 0; k < count; ++k) mj_step(s->model, s->data);
}

const char *mujoco_version(void) { return mj_versionString(); }
