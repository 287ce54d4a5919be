/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile's packets, made when a closed cell has to be opened: those of a picture, or from what its rays hit
 * to a light.
 */

/* Which lanes of a picture's packet hit something. The rays of one that is closed are made, if they are not there. */
static uint32_t find_seen(const struct mlrt_job *picture, struct ray_tile *seen, uint32_t place)
{
    struct mlrt_packet *packet = &seen->packets[place];
    const struct rectangle block = block_of_tile(seen, place);
    const uint32_t lanes = existing_lanes(&picture->source, &block);
    if (!(seen->made >> place & 1)) {
        get_packet(&picture->source, &block, lanes, packet);
        KEEP_LANES_LOOP
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            i_store(packet->triangle + v, i_set1(seen->cells.cover[place]));
        }
        seen->made |= 1u << place;
    }
    return lanes & ~lanes_of_triangle(packet, MLRT_NONE);
}

#if !MLRT_COUNTING
/* Makes the rays of a tile's packet to the light of a job. */
static MLRT_NOINLINE void make_rays_to_light(const struct mlrt_job *job, struct ray_tile *tile, uint32_t place)
{
    struct mlrt_packet *packet = &tile->packets[place];
    const uint32_t hit = find_seen(tile->picture, tile->seen, place);
    tile->made |= 1u << place;
    tile->dark[place] = 0;
    if (hit) {
        tile->dark[place] = make_shadow_packet(job, &tile->seen->packets[place], hit, packet);
    } else {
        packet->shear = NULL;
        check_packet(0, packet);
    }
}
#endif

/* Makes the rays of a tile's packet. */
static void make_rays(const struct mlrt_job *job, struct ray_tile *tile, uint32_t place)
{
#if !MLRT_COUNTING
    if (MLRT_UNLIKELY(tile->seen != NULL)) {
        make_rays_to_light(job, tile, place);
        return;
    }
#endif
    const struct rectangle block = block_of_tile(tile, place);
    get_packet(&job->source, &block, existing_lanes(&job->source, &block), &tile->packets[place]);
    tile->made |= 1u << place;
}
