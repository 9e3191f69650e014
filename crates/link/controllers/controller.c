/* A controller of your own against twinhub's plant; crates/link/STREAM.md describes the stream.
 *   cc -O2 -o controller controller.c && twinhub ride --controller ./controller
 * For little-endian machines: messages have no padding, so structs are what is on the line. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define LAYOUT 0x644437cfe60ef7bcull /* of the messages that this file is written for */
enum { HELLO = 1, PLANT = 3, CONTROLLER = 4 };
typedef struct { uint32_t stream, role, protocol, refused; uint64_t layout; uint32_t plant, controller; } Hello;
typedef struct { uint64_t protocol_hash, sequence, tick, time_ns; uint32_t state, reserved; } Header;
typedef struct {
    Header header;
    struct { uint64_t stamp_ns; float gyro_rad_s[3], accel_m_s2[3]; } imu;
    struct { uint64_t stamp_ns; float roll_rad, roll_rate_rad_s; } roll;
    struct { uint64_t stamp_ns; float steer_rad, steer_rate_rad_s; } steer;
    struct { uint64_t stamp_ns; float front_rad_s, rear_rad_s, speed_m_s; uint32_t reserved; } wheels;
    struct { uint64_t stamp_ns; float front_brake_nm, rear_traction_nm, bus_v, bus_a, winding_celsius; uint32_t reserved; } motors;
    struct { uint64_t stamp_ns; uint32_t assist_on, pedalling; float front_brake_ratio, rear_brake_ratio, pedal_nm, cadence_rad_s; } intent;
} PlantFrame;
typedef struct {
    Header header;
    float front_brake_nm, rear_traction_nm, demand_nm;
    uint32_t mode, health, limited_by;
    float estimate[8];
} ControllerFrame;
_Static_assert(sizeof(Hello) == 32 && sizeof(PlantFrame) == 192 && sizeof(ControllerFrame) == 96, "sizes");
typedef struct { char magic[4]; uint16_t kind, length; unsigned char payload[512 + 4]; } Packet;

static uint32_t checksum(const Packet *p) { /* CRC-32 of kind, length and payload */
    const unsigned char *bytes = (const unsigned char *)p;
    uint32_t crc = ~0u;
    for (size_t i = 4; i < 8u + p->length; i++)
        for (int bit = (crc ^= bytes[i], 0); bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    return ~crc;
}
static int receive(Packet *p) {
    uint32_t found;
    if (fread(p, 8, 1, stdin) != 1 || memcmp(p->magic, "TWHB", 4) || p->length > 512) return 0;
    if (fread(p->payload, p->length + 4u, 1, stdin) != 1) return 0;
    memcpy(&found, p->payload + p->length, 4);
    return found == checksum(p);
}
static void send(uint16_t kind, const void *message, uint16_t length) {
    Packet p = {{'T', 'W', 'H', 'B'}, kind, length, {0}};
    memcpy(p.payload, message, length);
    uint32_t crc = checksum(&p);
    memcpy(p.payload + length, &crc, 4);
    fwrite(&p, 8u + length + 4u, 1, stdout);
    fflush(stdout);
}
int main(void) { /* the pair grows by 10 Nm/s to 20 Nm between 3 and 9 m/s, while it is asked for */
    Packet p;
    double pair_nm = 0;
    while (receive(&p)) {
        if (p.kind == HELLO) {
            Hello theirs, mine = {1, 2, 1, 0, LAYOUT, sizeof(PlantFrame), sizeof(ControllerFrame)};
            memcpy(&theirs, p.payload, sizeof theirs);
            mine.refused = theirs.layout != LAYOUT;
            send(HELLO, &mine, sizeof mine);
        } else if (p.kind == PLANT) {
            PlantFrame f;
            memcpy(&f, p.payload, sizeof f);
            int wanted = f.intent.assist_on && f.wheels.speed_m_s > 3.0f && f.wheels.speed_m_s < 9.0f;
            pair_nm += wanted ? 0.01 : -0.01;
            pair_nm = pair_nm > 20 ? 20 : pair_nm < 0 ? 0 : pair_nm;
            ControllerFrame answer = {f.header, (float)pair_nm, (float)pair_nm, (float)pair_nm, 2, 0, 0, {0}};
            send(CONTROLLER, &answer, sizeof answer);
        }
    }
    return 0;
}
