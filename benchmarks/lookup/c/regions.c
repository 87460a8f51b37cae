/* Sequential search: regions one after the other until one holds the point, its rows one after the
   other until one is broken. With ALL_ROWS as PPOPT's point location does it: all rows of all
   regions first. Tables in regions.h. */
#include "peer.h"
#include "regions.h"

static const double *theta;
static int found;

static double product(int count, const double *restrict row, const double *restrict x)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        sum += row[i] * x[i];
    }
    return sum;
}

int peer_setup(const problem *p, double *f, double *low, double *high)
{
    peer_load(p, f, low, high);
    return 0;
}

void peer_load(const problem *p, double *f, double *low, double *high)
{
    (void)p;
    (void)low;
    (void)high;
    theta = f;
}

#ifdef ALL_ROWS
static unsigned char kept[FACETS];

static int located(const double *x)
{
    for (int i = 0; i < FACETS; i++) {
        kept[i] = product(COORDINATES, &normals[i * COORDINATES], x) <= heights[i];
    }
    for (int region = 0; region < REGIONS; region++) {
        int inside = 1;
        for (int i = starts[region]; i < starts[region + 1]; i++) {
            inside &= kept[i];
        }
        if (inside) {
            return region;
        }
    }
    return -1;
}
#else
static int located(const double *x)
{
    for (int region = 0; region < REGIONS; region++) {
        int i = starts[region];
        while (i < starts[region + 1]
               && product(COORDINATES, &normals[i * COORDINATES], x) <= heights[i]) {
            i++;
        }
        if (i == starts[region + 1]) {
            return region;
        }
    }
    return -1;
}
#endif

__attribute__((noinline)) int solve_one(void)
{
#ifdef IMAGE
    double eta[COORDINATES];
    for (int i = 0; i < COORDINATES; i++) {
        eta[i] = product(PARAMETERS, &matrix[i * PARAMETERS], theta) + shift[i];
    }
#else
    const double *eta = theta;
#endif
    found = located(eta);
    for (int j = 0; j < MOVES && found >= 0; j++) {
        const int row = laws[found] * MOVES + j;
        answer[j] = product(COORDINATES, &gains[row * COORDINATES], eta) + constants[row];
    }
    return found < 0;
}

int peer_answer(const problem *p)
{
    (void)p;
    return found;
}

/* all of it is static: read from the symbols of the linked program */
void peer_bytes(const problem *p, long *kept_, long *written)
{
    *kept_ = 8 * p->n;
    *written = 8;
}
