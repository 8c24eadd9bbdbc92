/* A system of Leafwise in C: the gyrostat, a rigid body with a spinning rotor.
 *
 *   {x1, x2} = -x3 and cyclic, H = x1^2/(2 I1) + x2^2/(2 I2) + x3^2/(2 I3) - rotor x3,
 *
 * so that Pi(x) v = x cross v; Casimir |x|^2.
 *
 *   cc -std=c11 -O3 -ffp-contract=off -fPIC -I plugins/abi/include -c plugins/examples/c/gyrostat.c
 *   cc -shared -o libgyrostat.so gyrostat.o
 *   leafwise plugin check ./libgyrostat.so
 */
#include "leafwise_plugin.h"

#include <stdlib.h>

typedef struct Gyrostat {
    double inverse_inertia[3], rotor;
} Gyrostat;

/* The parameters, in the order of `parameters` below. */
static LwStatus create(const LwCreate *args, void **instance, LwError *err) {
    if (args->setting_count != 4) return lw_fail(err, LW_ERROR, -1, "four parameters are expected");
    Gyrostat *body = malloc(sizeof *body);
    if (!body) return lw_fail(err, LW_ERROR, -1, "out of memory");
    for (int i = 0; i < 3; i++) {
        double inertia = args->settings[i].real;
        if (!(inertia > 0)) {
            free(body);
            return lw_fail(err, LW_UNSUPPORTED, -1, "moments of inertia are positive");
        }
        body->inverse_inertia[i] = 1 / inertia;
    }
    body->rotor = args->settings[3].real;
    *instance = body;
    return LW_OK;
}

static void destroy(void *instance) { free(instance); }

static size_t dimension(void *instance) {
    (void)instance;
    return 3;
}

static LwStatus tensor(void *instance, const LwMapCall *call, LwError *err) {
    (void)instance, (void)err;
    for (size_t i = 0; i < call->count; i++)
        for (size_t a = 0; a < 3; a++) {
            size_t b = (a + 1) % 3, c = (a + 2) % 3;
            lw_put(&call->output, i, a,
                   lw_get(&call->point, i, b) * lw_get(&call->v, i, c) -
                       lw_get(&call->point, i, c) * lw_get(&call->v, i, b));
        }
    return LW_OK;
}

static LwStatus tensor_tangent(void *instance, const LwMapCall *call, LwError *err) {
    (void)instance, (void)err; /* linear in the point: w cross v */
    for (size_t i = 0; i < call->count; i++)
        for (size_t a = 0; a < 3; a++) {
            size_t b = (a + 1) % 3, c = (a + 2) % 3;
            lw_put(&call->output, i, a,
                   lw_get(&call->w, i, b) * lw_get(&call->v, i, c) -
                       lw_get(&call->w, i, c) * lw_get(&call->v, i, b));
        }
    return LW_OK;
}

static LwStatus hamiltonian(void *instance, const LwMapCall *call, LwError *err) {
    const Gyrostat *body = instance;
    (void)err;
    for (size_t i = 0; i < call->count; i++) {
        double energy = 0;
        for (size_t a = 0; a < 3; a++) {
            double x = lw_get(&call->point, i, a);
            energy += 0.5 * body->inverse_inertia[a] * x * x;
        }
        lw_put(&call->output, i, 0, energy - body->rotor * lw_get(&call->point, i, 2));
    }
    return LW_OK;
}

static LwStatus gradient(void *instance, const LwMapCall *call, LwError *err) {
    const Gyrostat *body = instance;
    (void)err;
    for (size_t i = 0; i < call->count; i++)
        for (size_t a = 0; a < 3; a++)
            lw_put(&call->output, i, a,
                   body->inverse_inertia[a] * lw_get(&call->point, i, a) -
                       (a == 2 ? body->rotor : 0));
    return LW_OK;
}

static LwStatus hessian(void *instance, const LwMapCall *call, LwError *err) {
    const Gyrostat *body = instance;
    (void)err;
    for (size_t i = 0; i < call->count; i++)
        for (size_t a = 0; a < 3; a++)
            lw_put(&call->output, i, a, body->inverse_inertia[a] * lw_get(&call->v, i, a));
    return LW_OK;
}

static size_t casimir_count(void *instance) {
    (void)instance;
    return 1;
}

static const char *casimir_name(void *instance, size_t index) {
    (void)instance;
    return index == 0 ? "spin" : NULL;
}

static LwStatus casimirs(void *instance, const LwMapCall *call, LwError *err) {
    (void)instance, (void)err;
    for (size_t i = 0; i < call->count; i++) {
        double spin = 0;
        for (size_t a = 0; a < 3; a++)
            spin += lw_get(&call->point, i, a) * lw_get(&call->point, i, a);
        lw_put(&call->output, i, 0, spin);
    }
    return LW_OK;
}

static LwStatus casimir_gradients(void *instance, const LwMapCall *call, LwError *err) {
    (void)instance, (void)err;
    for (size_t i = 0; i < call->count; i++)
        for (size_t a = 0; a < 3; a++)
            lw_put(&call->output, i, a, 2 * lw_get(&call->point, i, a));
    return LW_OK;
}

static const LwParameter parameters[] = {
    {"I1", "moment of inertia about the first axis", "1.0"},
    {"I2", "moment of inertia about the second axis", "0.75"},
    {"I3", "moment of inertia about the third axis", "1.25"},
    {"rotor", "angular velocity that the rotor adds about the third axis", "0.3"},
};

static const LwSystem functions = {
    .struct_size = sizeof(LwSystem),
    .life = {.create = create, .destroy = destroy},
    .dimension = dimension,
    .tensor = tensor,
    .hamiltonian = hamiltonian,
    .gradient = gradient,
    .casimir_count = casimir_count,
    .casimir_name = casimir_name,
    .casimirs = casimirs,
    .casimir_gradients = casimir_gradients,
    .tensor_tangent = tensor_tangent,
    .hessian = hessian,
};

static const LwPart gyrostat = {
    .struct_size = sizeof(LwPart),
    .kind = LW_KIND_SYSTEM,
    .id = "example-c/gyrostat",
    .summary = "a rigid body with a spinning rotor",
    .domain = "all states",
    .reference = "Volterra, Acta Math. 22 (1899) 201-357",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .functions = &functions,
};

static const LwPart *const parts[] = {&gyrostat};

static const LwEntry entry = {
    .magic = {'L', 'E', 'A', 'F', 'W', 'I', 'S', 'E'},
    .abi_major = LW_ABI_MAJOR,
    .struct_size = sizeof(LwEntry),
    .real_bytes = sizeof(double),
    .part_count = 1,
    .parts = parts,
    .id = "example-c",
    .version = "1.0.0",
    .license = "MIT OR Apache-2.0",
    .toolchain = "C11",
};

const LwEntry *leafwise_plugin_entry_v1(void) { return &entry; }
