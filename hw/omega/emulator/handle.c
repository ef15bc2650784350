/* A simulated haptic device behind the names of the vendor's library.
 *
 * The handle is a point mass with damping, held by a hand (a spring and damper to a target that moves) between end
 * stops; a force that is set moves it, and what is read back has the resolution of encoders and the lag of the vendor's
 * velocity window. Device frame: x towards the operator, y to the operator's right, z up.
 *
 * `struct emulated` is written into emulated.h when this is built, all of it double; a test reads and writes it through
 * ctypes. A program that knows nothing of all this finds two devices that live in real time; the variable EMULATED_OMEGA
 * may then set members of both, as in "target_z=-0.02 swing_x=0.02 swing_hz=1.5". What the bindings call and this file
 * does not define is generated as a function that fails.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "emulated.h"

#define DEVICES 2
#define TICK 1e-4           /* [s] of the handle's integration */
#define HISTORY 1024        /* ticks of position kept for the velocity window */
#define MOST_CATCH_UP 1.0   /* [s] simulated at once after a pause */
#define GRAVITY 9.81
#define WIDEST 0.025        /* [m] of the trigger */
#define FINGER_MASS 0.05    /* [kg] */
#define FINGER_DAMPING 5.0  /* [N s/m] */

enum { NO_ERROR = 0, COM = 2, NO_DEVICE_FOUND = 5, TIMEOUT = 7, EXPERT_MODE_DISABLED = 9, NOT_IMPLEMENTED = 10,
       INVALID_INDEX = 15, IN_USE = 20, INVALID = 21 };
enum { MOTOR_SATURATED = 2 };
enum { CAUSE_NOT_OFF = 0, CAUSE_BUTTON = 1, CAUSE_WATCHDOG = 3, CAUSE_SOFTWARE = 4, CAUSE_USB = 5 };

struct emulated emulated[DEVICES];

static struct device {
    double history[HISTORY][3];
    long tick;
    double force[3], grip;   /* set by the host [N] */
    double last_set;         /* when [s] */
    double window;           /* of the velocity estimate [s] */
    double cause;
    bool open, enabled, gravity, button_off, gripper_is_button;
} devices[DEVICES];

static int last_error, default_device, expert_mode;

static double wall(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---------------------------------------------------------------------------------------------------- the simulation */
static bool forces_on(const struct emulated *e, const struct device *d) {
    return d->open && d->enabled && !d->button_off && d->cause == CAUSE_NOT_OFF && e->powered != 0.0;
}

static void tick(struct emulated *e, struct device *d) {
    const double t = e->simulated;
    if (d->enabled && e->watchdog > 0.0 && d->cause == CAUSE_NOT_OFF && t - d->last_set > e->watchdog)
        d->cause = CAUSE_WATCHDOG;  /* the firmware's own, which needs no host */
    if (d->button_off != (e->force_button != 0.0)) {
        d->button_off = !d->button_off;
        d->cause = d->button_off ? CAUSE_BUTTON : CAUSE_NOT_OFF;
    }
    const bool on = forces_on(e, d);
    const double braking = on ? 0.0 : e->brake;
    double r = 0.0;
    double *x = &e->x, *v = &e->vx, *applied = &e->applied_x, *target = &e->target_x;
    const double *const waves[] = {&e->swing_x, &e->sway_x, &e->tremor_x};  /* x, y, z and the frequency */
    for (int i = 0; i < 3; i++) r += x[i] * x[i];
    r = sqrt(r);
    const double part = e->soft_start > 0.0 && t < e->soft_start ? t / e->soft_start : 1.0;
    const double taken = part * part * (3.0 - 2.0 * part);
    for (int i = 0; i < 3; i++) {
        double wanted = target[i], rate = 0.0;
        for (int k = 0; k < 3; k++) {
            const double w = 6.283185307179586 * waves[k][3];
            wanted += waves[k][i] * sin(w * t);
            rate += waves[k][i] * w * cos(w * t);
        }
        wanted *= taken;
        rate *= taken;
        applied[i] = on ? d->force[i] : 0.0;
        double total = applied[i] - (e->damping + braking) * v[i];
        total += e->hand_stiffness * (wanted - x[i]) + e->hand_damping * (rate - v[i]);
        if (i == 2 && !(on && d->gravity)) total -= e->mass * GRAVITY;
        if (r > e->reach) total -= 5000.0 * (r - e->reach) * x[i] / r + 20.0 * v[i];  /* the end stop */
        v[i] += TICK * total / (e->mass + e->hand_mass);
        x[i] += TICK * v[i];
    }
    e->applied_grip = on ? d->grip : 0.0;
    e->gap_rate += TICK * (e->applied_grip - e->squeeze - FINGER_DAMPING * e->gap_rate) / FINGER_MASS;
    e->gap += TICK * e->gap_rate;
    if (e->gap < 0.0 || e->gap > WIDEST) { e->gap = e->gap < 0.0 ? 0.0 : WIDEST; e->gap_rate = 0.0; }
    if (fabs(e->applied_grip) > e->greatest_grip) e->greatest_grip = fabs(e->applied_grip);
    d->tick++;
    memcpy(d->history[d->tick % HISTORY], x, sizeof d->history[0]);
    const double size = sqrt(applied[0] * applied[0] + applied[1] * applied[1] + applied[2] * applied[2]);
    if (size > e->greatest_force) e->greatest_force = size;
    if (size > 0.0) e->last_force_at = t + TICK;
    e->force_off_cause = d->cause;
}

static void simulate_until(struct emulated *e, struct device *d, double t) {
    if (t - e->simulated > MOST_CATCH_UP) e->simulated = t - MOST_CATCH_UP;
    while (e->simulated + TICK <= t + 1e-9) {
        tick(e, d);
        e->simulated += TICK;
    }
}

static double now_of(const struct emulated *e) {
    return e->real_time != 0.0 ? wall() - e->epoch : e->clock;
}

/* Called by the test's own program. */
void emulated_update(int id) { simulate_until(&emulated[id], &devices[id], now_of(&emulated[id])); }

void emulated_reset(int id) {
    struct emulated *e = &emulated[id];
    memset(e, 0, sizeof *e);
    memset(&devices[id], 0, sizeof devices[id]);
    e->mass = 0.25; e->damping = 0.3; e->brake = 10.0; e->reach = 0.08; e->strongest = 12.0; e->resolution = 5e-6;
    e->hand_mass = 0.15; e->hand_damping = 4.0; e->hand_stiffness = 250.0;
    e->gap = WIDEST;
    e->powered = e->connected = e->calibrated = 1.0;
    e->type = 35.0;          /* an Omega.7 for the right hand */
    e->serial = 1000.0 + id;
    e->epoch = wall();
    devices[id].window = 0.020;
    last_error = NO_ERROR; default_device = 0; expert_mode = 0;
}

static void set_member(const char *assignment) {
    for (size_t i = 0; i < sizeof emulated_names / sizeof *emulated_names; i++) {
        const size_t length = strlen(emulated_names[i]);
        if (strncmp(assignment, emulated_names[i], length) == 0 && assignment[length] == '=')
            for (int id = 0; id < DEVICES; id++) ((double *)&emulated[id])[i] = strtod(assignment + length + 1, NULL);
    }
}

__attribute__((constructor)) static void at_load(void) {
    for (int id = 0; id < DEVICES; id++) {
        emulated_reset(id);
        emulated[id].real_time = 1.0;
    }
    const char *members = getenv("EMULATED_OMEGA");
    char copy[1024] = "";
    if (members != NULL) strncpy(copy, members, sizeof copy - 1);
    for (char *word = strtok(copy, " "); word != NULL; word = strtok(NULL, " ")) set_member(word);
}

/* ---------------------------------------------------------------------------------------------------------- the calls */
static int fail(int error) { last_error = error; return -1; }

/* Whom a call is for, or NULL with the error set; what makes every call fail or slow lives here. */
static struct device *device(signed char id) {
    if (id < 0) id = (signed char)default_device;
    if (id >= DEVICES) { fail(INVALID_INDEX); return NULL; }
    struct emulated *e = &emulated[id];
    e->calls += 1.0;
    if (e->slow > 0.0) {
        if (e->real_time != 0.0) for (const double until = wall() + e->slow; wall() < until;);
        else e->clock += e->slow;
    }
    simulate_until(e, &devices[id], now_of(e));
    if (e->connected == 0.0) { devices[id].cause = CAUSE_USB; fail(COM); return NULL; }
    if (e->failing > 0.0) { e->failing -= 1.0; fail((int)e->error); return NULL; }
    if (!devices[id].open) { fail(NO_DEVICE_FOUND); return NULL; }
    return &devices[id];
}
#define OF(d) (&emulated[(d) - devices])
#define DEVICE(id) struct device *d = device(id); if (d == NULL) return -1; struct emulated *e = OF(d); (void)e

static double rounded(const struct emulated *e, double value) {
    return e->resolution > 0.0 ? e->resolution * round(value / e->resolution) : value;
}

void dhdGetSDKVersion(int *major, int *minor, int *release, int *revision) {
    *major = 3; *minor = 17; *release = 1; *revision = 0;
}
int dhdErrorGetLast(void) { return last_error; }
const char *dhdErrorGetLastStr(void) { return last_error == NO_ERROR ? "no error" : "emulated error"; }
const char *dhdErrorGetStr(int error) { return error == NO_ERROR ? "no error" : "emulated error"; }
double dhdGetTime(void) { return now_of(&emulated[default_device]); }

int dhdGetDeviceCount(void) {
    int count = 0;
    for (int i = 0; i < DEVICES; i++) count += emulated[i].connected != 0.0;
    return count;
}
int dhdGetAvailableCount(void) {
    int count = 0;
    for (int i = 0; i < DEVICES; i++) count += emulated[i].connected != 0.0 && !devices[i].open;
    return count;
}
int dhdOpenID(signed char id) {
    if (id < 0 || id >= DEVICES || emulated[id].connected == 0.0) return fail(NO_DEVICE_FOUND);
    if (devices[id].open) return fail(IN_USE);
    devices[id].open = true;
    devices[id].enabled = false;
    devices[id].cause = CAUSE_NOT_OFF;
    default_device = id;
    emulated_update(id);
    return id;
}
int dhdOpen(void) {
    for (signed char i = 0; i < DEVICES; i++)
        if (!devices[i].open && emulated[i].connected != 0.0) return dhdOpenID(i);
    return fail(NO_DEVICE_FOUND);
}
int dhdOpenSerial(int serial) {
    for (signed char i = 0; i < DEVICES; i++) if ((int)emulated[i].serial == serial) return dhdOpenID(i);
    return fail(NO_DEVICE_FOUND);
}
int drdOpenID(signed char id) { return dhdOpenID(id); }
int drdOpen(void) { return dhdOpen(); }
int dhdClose(signed char id) {
    DEVICE(id);
    d->open = d->enabled = false;
    memset(d->force, 0, sizeof d->force);
    d->grip = 0.0;
    return 0;
}
int drdClose(signed char id) { return dhdClose(id); }
int dhdSetDevice(signed char id) {
    if (id < 0 || id >= DEVICES) return fail(INVALID_INDEX);
    default_device = id;
    return 0;
}
int dhdGetDeviceID(void) { return default_device; }
int dhdGetSystemType(signed char id) { DEVICE(id); return (int)e->type; }
const char *dhdGetSystemName(signed char id) { return device(id) == NULL ? NULL : "emulated omega.7"; }
int dhdGetSerialNumber(unsigned short *serial, signed char id) { DEVICE(id); *serial = (unsigned short)e->serial; return 0; }
bool dhdIsLeftHanded(signed char id) { (void)id; return false; }

bool drdIsInitialized(signed char id) { struct device *d = device(id); return d != NULL && OF(d)->calibrated != 0.0; }
bool drdIsSupported(signed char id) { return device(id) != NULL; }
int drdAutoInit(signed char id) { DEVICE(id); e->calibrated = 1.0; return 0; }

int dhdSetGravityCompensation(bool enable, signed char id) { DEVICE(id); d->gravity = enable; return 0; }
int dhdSetEffectorMass(double mass, signed char id) { DEVICE(id); return mass >= 0.0 ? 0 : fail(INVALID); }
int dhdSetStandardGravity(double g, signed char id) { DEVICE(id); return isfinite(g) ? 0 : fail(INVALID); }
int dhdEnableExpertMode(void) { expert_mode = 1; return 0; }
int dhdDisableExpertMode(void) { expert_mode = 0; return 0; }
int dhdSetWatchdog(unsigned char duration, signed char id) {
    DEVICE(id);
    if (!expert_mode) return fail(EXPERT_MODE_DISABLED);
    if (e->no_watchdog != 0.0) return fail(NOT_IMPLEMENTED);
    e->watchdog = 125e-6 * duration;
    d->last_set = e->simulated;
    return 0;
}
int dhdGetWatchdog(unsigned char *duration, signed char id) {
    DEVICE(id);
    *duration = (unsigned char)round(e->watchdog / 125e-6);
    return 0;
}
int dhdEnableForce(bool enable, signed char id) {
    DEVICE(id);
    if (enable) {
        if (d->button_off) return 0;  /* only the button itself gives it back */
        d->cause = CAUSE_NOT_OFF;
        d->last_set = e->simulated;
    } else d->cause = CAUSE_SOFTWARE;
    memset(d->force, 0, sizeof d->force);
    d->grip = 0.0;
    d->enabled = enable;
    return 0;
}
int dhdStop(signed char id) { return dhdEnableForce(false, id); }
int dhdSetBrakes(bool enable, signed char id) { (void)enable; DEVICE(id); return 0; }

int dhdGetStatus(int *status, signed char id) {
    DEVICE(id);
    memset(status, 0, 17 * sizeof *status);
    status[0] = e->powered != 0.0;
    status[1] = 1;
    status[2] = 1;
    status[3] = e->calibrated != 0.0;
    status[5] = forces_on(e, d);
    status[6] = !status[5];
    status[10] = d->gravity;
    status[14] = (int)d->cause;
    return 0;
}

int dhdGetPosition(double *x, double *y, double *z, signed char id) {
    DEVICE(id);
    e->asked_at = wall();
    if (e->stuck == 0.0) { e->read_x = rounded(e, e->x); e->read_y = rounded(e, e->y); e->read_z = rounded(e, e->z); }
    *x = e->nan_position != 0.0 ? NAN : e->read_x + e->jump;
    *y = e->read_y;
    *z = e->read_z;
    return 0;
}
int dhdGetOrientationFrame(double matrix[3][3], signed char id) {
    DEVICE(id);
    for (int i = 0; i < 3; i++) for (int j = 0; j < 3; j++) matrix[i][j] = i == j;
    return 0;
}
int dhdGetPositionAndOrientationFrame(double *x, double *y, double *z, double matrix[3][3], signed char id) {
    return dhdGetPosition(x, y, z, id) < 0 ? -1 : dhdGetOrientationFrame(matrix, id);
}
int dhdConfigLinearVelocity(int ms, int mode, signed char id) {
    DEVICE(id);
    if (ms < 1 || ms > 100 || mode != 0) return fail(INVALID);
    d->window = 1e-3 * ms;
    return 0;
}
int dhdGetLinearVelocity(double *vx, double *vy, double *vz, signed char id) {
    DEVICE(id);
    long window = (long)round(d->window / TICK);
    if (window > d->tick - 1) window = d->tick - 1;
    double *out[3] = {vx, vy, vz};
    for (int i = 0; i < 3; i++) {
        if (window < 1) { *out[i] = 0.0; continue; }
        const double newer = d->history[d->tick % HISTORY][i], older = d->history[(d->tick - window) % HISTORY][i];
        *out[i] = e->nan_velocity != 0.0 ? NAN : (rounded(e, newer) - rounded(e, older)) / (window * TICK);
    }
    return 0;
}
int dhdSetForce(double fx, double fy, double fz, signed char id) {
    DEVICE(id);
    const double size = sqrt(fx * fx + fy * fy + fz * fz);
    if (!isfinite(size)) { e->not_finite += 1.0; return fail(INVALID); }
    const double scale = size > e->strongest ? e->strongest / size : 1.0;
    d->force[0] = scale * fx; d->force[1] = scale * fy; d->force[2] = scale * fz;
    d->last_set = e->simulated;
    e->sets += 1.0;
    e->answered_after = wall() - e->asked_at;
    return scale < 1.0 ? MOTOR_SATURATED : 0;
}
int dhdSetForceAndGripperForce(double fx, double fy, double fz, double fg, signed char id) {
    const int done = dhdSetForce(fx, fy, fz, id);
    if (done < 0) return done;
    DEVICE(id);
    if (!isfinite(fg)) { e->not_finite += 1.0; return fail(INVALID); }
    d->grip = fg;
    return done;
}
int dhdGetGripperGap(double *gap, signed char id) {
    DEVICE(id);
    *gap = e->nan_gap != 0.0 ? NAN : rounded(e, e->gap);
    return 0;
}
int dhdGetForce(double *fx, double *fy, double *fz, signed char id) {
    DEVICE(id);
    *fx = e->applied_x; *fy = e->applied_y; *fz = e->applied_z;
    return 0;
}
bool dhdHasGripper(signed char id) { return device(id) != NULL; }
int dhdEmulateButton(bool enable, signed char id) { DEVICE(id); d->gripper_is_button = enable; return 0; }
int dhdGetButton(int index, signed char id) {
    DEVICE(id);
    return index == 0 ? d->gripper_is_button && e->button != 0.0 : fail(INVALID_INDEX);
}
double dhdGetComFreq(signed char id) { (void)id; return 4.0; }
