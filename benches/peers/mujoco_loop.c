/* MuJoCo's own C loop on M1, M2 and M4, under the same sampled force control.
 *
 *   mujoco_loop rows                    work and peak force of every machine, integrator and step, as CSV
 *   mujoco_loop map VARIANTS THREADS    seconds that many variants of M2 take on as many free processors,
 *                                       two simulated seconds each, 0.1 ms steps
 *
 * The contact is an explicit force, evaluated at every stage of an integrator by the callback for passive
 * forces. MuJoCo's own contact cannot be given a stiffness in N/m, since its reference acceleration scales
 * with the mass that touches. A further row has that own contact, for its cost only.
 * Everything the machine does not need is switched off.
 */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <mujoco/mujoco.h>

enum { CONTACT_N_PER_M, CONTACT_N_S_PER_M, DRIVE_N, GAIN, USERDATA };

#define OPTIONS \
  "<option timestep='1e-4' gravity='0 0 0'>" \
  "<flag %s gravity='disable' sensor='disable' actuation='disable' limit='disable'" \
  " frictionloss='disable' equality='disable' eulerdamp='disable'/></option><size nuserdata='4'/>"
#define FREE_OF_CONSTRAINTS "constraint='disable' contact='disable'"
#define INERTIA(mass) "<inertial pos='0 0 0' mass='" mass "' diaginertia='1 1 1'/>"
#define SLIDE(rest) "<joint type='slide' axis='1 0 0' " rest "/>"
/* For the own contact only: a ball whose foremost point is at the body's position, against a block that
 * starts there. */
#define GEOM(rest) "<geom mass='0' condim='1' solref='-1e5 -100' solimp='0.95 0.99 0.001' " rest "/>"
#define BALL GEOM("type='sphere' size='0.05' pos='-0.05 0 0'")
#define BLOCK GEOM("type='box' size='0.05 1 1' pos='0.05 0 0'")

/* Arguments of each world's text: options, the ground's block, the tip's ball, the workpiece's block. */
static const char *const WORLD[3] = {
    "<mujoco>%s<worldbody>%s<body>" INERTIA("10") SLIDE("damping='50'") "%s</body></worldbody>%s</mujoco>",
    "<mujoco>%s<worldbody>%s<body>" INERTIA("6") SLIDE("damping='50'")
    "<body>" INERTIA("4") SLIDE("stiffness='4e5' damping='60'") "%s</body></body></worldbody>%s</mujoco>",
    "<mujoco>%s<worldbody>%s<body>" INERTIA("200") SLIDE("stiffness='1.1e6' damping='600'")
    "<body>" INERTIA("6") SLIDE("damping='50'")
    "<body>" INERTIA("4") SLIDE("stiffness='4e5' damping='60'") "%s</body></body>"
    "<body>" INERTIA("5") SLIDE("stiffness='1e6' damping='200'") "%s</body></body></worldbody></mujoco>",
};
static const char *const NAME[3] = {"M1", "M2", "M4"};

/* Processor time of all threads: the runs are long enough for other programs to cut in. */
static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

static double contact_n(const mjModel *m, const mjData *d) {
  const mjtNum *q = d->qpos, *v = d->qvel;
  double gap, rate;
  switch (m->nv) {
    case 1: gap = q[0]; rate = v[0]; break;
    case 2: gap = q[0] + q[1]; rate = v[0] + v[1]; break;
    default: gap = q[1] + q[2] - q[3]; rate = v[1] + v[2] - v[3];
  }
  const double force = d->userdata[CONTACT_N_PER_M] * gap + d->userdata[CONTACT_N_S_PER_M] * rate;
  return gap > 0 && force > 0 ? force : 0;
}

/* Each coordinate is relative to the parent body, so forces act on every joint between the ground and the
 * body that carries them. */
static void explicit_contact(const mjModel *m, mjData *d) {
  const double force = contact_n(m, d);
  switch (m->nv) {
    case 1: d->qfrc_passive[0] -= force; break;
    case 2: d->qfrc_passive[0] -= force; d->qfrc_passive[1] -= force; break;
    default: d->qfrc_passive[1] -= force; d->qfrc_passive[2] -= force; d->qfrc_passive[3] += force;
  }
}

static double own_contact_n(const mjModel *m, const mjData *d) {
  (void)m;
  double sum = 0;
  for (int i = 0; i < d->nefc; i++) sum += d->efc_force[i];
  return sum;
}

static mjModel *load(int machine, int own_contact) {
  char options[1024], xml[4096], error[500];
  const int on_ground = machine < 2;
  snprintf(options, sizeof options, OPTIONS, own_contact ? "" : FREE_OF_CONSTRAINTS);
  snprintf(xml, sizeof xml, WORLD[machine], options, own_contact && on_ground ? BLOCK : "",
           own_contact ? BALL : "", own_contact && !on_ground ? BLOCK : "");
  mjVFS vfs;
  mj_defaultVFS(&vfs);
  mj_addBufferVFS(&vfs, "model.xml", xml, (int)strlen(xml));
  mjModel *m = mj_loadXML("model.xml", &vfs, error, sizeof error);
  mj_deleteVFS(&vfs);
  if (!m) {
    fprintf(stderr, "%s\n", error);
    exit(1);
  }
  return m;
}

static void start(const mjModel *m, mjData *d) {
  mj_resetData(m, d);
  d->qpos[m->nv == 4 ? 1 : 0] = -5e-3;
  d->userdata[CONTACT_N_PER_M] = 1e5;
  d->userdata[CONTACT_N_S_PER_M] = 100;
  d->userdata[GAIN] = 2;
}

/* Sampled force control for `samples` milliseconds; gives the largest force on a grid of 0.1 ms. */
static double loop(const mjModel *m, mjData *d, int samples, int steps,
                   double (*force)(const mjModel *, const mjData *)) {
  const int driven = m->nv == 4 ? 1 : 0;
  double peak = 0, f = force(m, d);
  for (int k = 0; k < samples; k++) {
    const double u = 20 + d->userdata[GAIN] * (20 - f);
    d->qfrc_applied[driven] = u > 200 ? 200 : u < -200 ? -200 : u;
    for (int i = 0; i < steps; i++) {
      mj_step(m, d);
      if ((i + 1) % (steps / 10)) continue;
      f = force(m, d);
      if (f > peak) peak = f;
    }
  }
  return peak;
}

static int by_size(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void row(int machine, int integrator, int steps, int own_contact) {
  enum { ROUNDS = 5, SAMPLES = 1000 };
  mjModel *m = load(machine, own_contact);
  m->opt.integrator = integrator;
  m->opt.timestep = 1e-3 / steps;
  mjcb_passive = own_contact ? NULL : explicit_contact;
  mjData *d = mj_makeData(m);
  double wall[ROUNDS], peak = 0;
  for (int round = 0; round < ROUNDS; round++) {
    start(m, d);
    const double begin = seconds();
    peak = loop(m, d, SAMPLES, steps, own_contact ? own_contact_n : contact_n);
    wall[round] = (seconds() - begin) / (1e-3 * SAMPLES);
  }
  qsort(wall, ROUNDS, sizeof *wall, by_size);
  const char *explicit_method = integrator == mjINT_RK4 ? "RK4" : "semi-implicit Euler";
  const char *method = own_contact ? "own contact, Euler" : explicit_method;
  printf("MuJoCo C loop,\"%s\",%s,%g,%.6e,%.12f\n", method, NAME[machine], 1e-3 / steps,
         wall[ROUNDS / 2], peak);
  mj_deleteData(d);
  mj_deleteModel(m);
}

typedef struct {
  const mjModel *m;
  int first, last, side;
} Share;

static void *work(void *argument) {
  const Share *share = argument;
  mjData *d = mj_makeData(share->m);
  for (int i = share->first; i < share->last; i++) {
    start(share->m, d);
    d->userdata[CONTACT_N_PER_M] = 5e4 * pow(4.0, (i % share->side) / (double)share->side);
    d->userdata[GAIN] = 0.5 * pow(4.0, (i / share->side % share->side) / (double)share->side);
    loop(share->m, d, 2000, 10, contact_n);
  }
  mj_deleteData(d);
  return NULL;
}

static void map(int variants, int threads) {
  mjModel *m = load(1, 0);
  m->opt.integrator = mjINT_EULER;
  mjcb_passive = explicit_contact;
  pthread_t thread[64];
  Share share[64];
  const double begin = seconds();
  for (int t = 0; t < threads; t++) {
    share[t] = (Share){m, (int)((long)variants * t / threads), (int)((long)variants * (t + 1) / threads), 64};
    pthread_create(&thread[t], NULL, work, &share[t]);
  }
  for (int t = 0; t < threads; t++) pthread_join(thread[t], NULL);
  printf("%.6f\n", (seconds() - begin) / threads);
  mj_deleteModel(m);
}

int main(int count, char **arguments) {
  if (count == 4 && !strcmp(arguments[1], "map") && atoi(arguments[3]) <= 64) {
    map(atoi(arguments[2]), atoi(arguments[3]));
    return 0;
  }
  if (count != 2 || strcmp(arguments[1], "rows")) {
    fprintf(stderr, "mujoco_loop rows | mujoco_loop map VARIANTS THREADS\n");
    return 2;
  }
  for (int machine = 0; machine < 3; machine++) {
    for (int steps = 10; steps <= 40; steps *= 2) {
      row(machine, mjINT_EULER, steps, 0);
      row(machine, mjINT_RK4, steps, 0);
    }
    row(machine, mjINT_EULER, 10, 1);
  }
  return 0;
}
